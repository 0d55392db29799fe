"""Small line charts as SVG text, without any library: panels side by side over one set of categories."""
import math

WIDTH, HEIGHT, LEFT, TOP, GAP = 210, 150, 46, 34, 22
COLOURS = ["#1f5fa8", "#c2571a", "#3d8b4f", "#7a4fa3", "#888888"]


def panels(charts, categories, x_label, y_label, y_range, logarithmic=False):
    """An SVG document with one panel for each of `charts`, a dict of titles to {name: [value or None per category]}.

    `y_range` is (lowest, highest); values beyond it are drawn at its border. Series of one name have one colour in all
    panels; names that start with `STLSQ` or `least squares` are dashed."""
    names = list(dict.fromkeys(name for series in charts.values() for name in series))
    total = LEFT + len(charts) * (WIDTH + GAP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{total}" height="{TOP + HEIGHT + 62}" '
        'font-family="sans-serif" font-size="11">',
        '<rect width="100%" height="100%" fill="white"/>',
        f'<text transform="translate(12 {TOP + HEIGHT / 2}) rotate(-90)" text-anchor="middle">{y_label}</text>',
    ]
    scale = math.log10 if logarithmic else float
    low, high = scale(y_range[0]), scale(y_range[1])

    def height(value):
        share = (scale(min(max(value, y_range[0]), y_range[1])) - low) / (high - low)
        return TOP + HEIGHT * (1 - share)

    def place(left, i):
        return left + 12 + (WIDTH - 24) * i / max(1, len(categories) - 1)

    if logarithmic:
        ticks = [10.0 ** e for e in range(math.ceil(low), math.floor(high) + 1, max(1, round((high - low) / 5)))]
    else:
        ticks = [y_range[0] + (y_range[1] - y_range[0]) * i / 4 for i in range(5)]
    for number, (title, series) in enumerate(charts.items()):
        left = LEFT + number * (WIDTH + GAP)
        parts.append(f'<text x="{left + WIDTH / 2}" y="{TOP - 12}" text-anchor="middle" font-weight="bold">{title}</text>')
        for tick in ticks:
            y = height(tick)
            parts.append(f'<path d="M{left} {y:.1f}h{WIDTH}" stroke="#dddddd"/>')
            if number == 0:
                label = f"1e{round(math.log10(tick))}" if logarithmic else f"{tick:g}"
                parts.append(f'<text x="{left - 4}" y="{y + 4:.1f}" text-anchor="end">{label}</text>')
        for i, category in enumerate(categories):
            parts.append(f'<text x="{place(left, i):.1f}" y="{TOP + HEIGHT + 14}" text-anchor="middle">{category}</text>')
        for name, values in series.items():
            colour = COLOURS[names.index(name) % len(COLOURS)]
            dashes = ' stroke-dasharray="4 3"' if name.startswith(("STLSQ", "least squares")) else ""
            points = [(place(left, i), height(v)) for i, v in enumerate(values) if v is not None]
            path = "L".join(f"{x:.1f} {y:.1f}" for x, y in points)
            if path:
                parts.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="1.8"{dashes}/>')
            parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.4" fill="{colour}"/>' for x, y in points]
    middle = LEFT + (total - LEFT) / 2
    parts.append(f'<text x="{middle}" y="{TOP + HEIGHT + 32}" text-anchor="middle">{x_label}</text>')
    at = LEFT
    for i, name in enumerate(names):
        colour = COLOURS[i % len(COLOURS)]
        parts.append(f'<path d="M{at} {TOP + HEIGHT + 48}h18" stroke="{colour}" stroke-width="2.5"/>')
        parts.append(f'<text x="{at + 23}" y="{TOP + HEIGHT + 52}">{name}</text>')
        at += 40 + 6.3 * len(name)
    return "\n".join(parts) + "\n</svg>\n"
