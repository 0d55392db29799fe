const find = id => document.getElementById(id);
const picture = find('picture'), pen = picture.getContext('2d');
const identified = C.slice(), n = FACTS.names.length, past = [];
// Real time, or what eyes can follow: thirty steps a second where that is slower, three hundred where it is faster.
const pace = DT > 0.25 ? 30 : DT < 0.002 ? 300 : 1 / DT;
const held = FACTS.held.slice(), STRIP = 900, LONG_AT_BOUND = 60;
let x = [], begun = 0, due = 0, last = 0, playing = true, push = 0, u = [], fell = '', bound = 0;

const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name);
const range = i => FACTS.controls[i] || [-1, 1];
const policyActs = () => FACTS.policy && find('policy').checked;

function begin(why = '') {
  x = FACTS.starts[begun % FACTS.starts.length].slice();
  begun += 1;
  past.length = 0;
  past.push(x.concat(held));
  due = bound = 0;
  fell = why;
}

function forward() {
  u = policyActs() ? chosen(x).slice() : held.slice();
  if (u.length) u[+find('which').value] += push;
  const after = next(x, u);
  if (!after.every(Number.isFinite)) {
    begin('the state left the finite numbers; begun anew');
    return;
  }
  x = after;
  past.push(x.concat(u));
  if (past.length > STRIP) past.shift();
  // Episodes end there, or nothing moves any more.
  const at = x.findIndex((value, i) => value === BOUNDS[i][0] || value === BOUNDS[i][1]);
  bound = at < 0 ? 0 : bound + 1;
  if (bound > LONG_AT_BOUND) begin(`${FACTS.names[at]} stayed at its declared bound; begun anew`);
  else if (past.length > 90) fell = '';
}

// Where a value lies between the ends of all that were seen.
function ends(i) {
  let low = Infinity, high = -Infinity;
  for (const row of past) { low = Math.min(low, row[i]); high = Math.max(high, row[i]); }
  if (!(high > low)) { low -= 1; high += 1; }
  return [low - 0.05 * (high - low), high + 0.05 * (high - low)];
}

function line(points, name, width) {
  pen.strokeStyle = colour(name);
  pen.lineWidth = width;
  pen.beginPath();
  points.forEach(([a, b], i) => (i ? pen.lineTo(a, b) : pen.moveTo(a, b)));
  pen.stroke();
}

const disc = (a, b, r, name) => { pen.fillStyle = colour(name); pen.beginPath(); pen.arc(a, b, r, 0, 7); pen.fill(); };

function body(width, height) {
  const shape = FACTS.shape, middle = width / 2, floor = 0.7 * height, unit = 0.3 * height;
  if (shape.kind === 'cart-pole') {
    const reach = Math.max(2.4, Math.abs(x[shape.x])), at = middle + (x[shape.x] / reach) * 0.42 * width;
    line([[0, height / 2 + 10], [width, height / 2 + 10]], '--line', 1);
    pen.fillStyle = colour('--ink');
    pen.fillRect(at - 26, height / 2 - 10, 52, 20);
    const tip = [at + unit * 1.4 * Math.sin(x[shape.angle]), height / 2 - unit * 1.4 * Math.cos(x[shape.angle])];
    line([[at, height / 2], tip], '--model', 7);
    return [at, height / 2];
  }
  if (shape.kind === 'pendulum') {
    const tip = [middle - unit * 1.4 * Math.sin(x[shape.angle]), height / 2 - unit * 1.4 * Math.cos(x[shape.angle])];
    line([[middle, height / 2], tip], '--model', 7);
    disc(...tip, 11, '--ink');
    return tip;
  }
  if (shape.kind === 'car') {
    const across = v => ((v + 1.25) / 1.9) * width, up = v => floor - 0.3 * height * Math.sin(3 * v);
    const hill = Array.from({ length: 101 }, (_, i) => -1.25 + 0.019 * i);
    line(hill.map(v => [across(v), up(v)]), '--soft', 2);
    disc(across(x[shape.x]), up(x[shape.x]) - 9, 9, '--model');
    return [across(x[shape.x]), up(x[shape.x]) - 9];
  }
  if (!past.length) return [middle, height / 2];
  const j = Math.min(1, n - 1), [a, b] = ends(0), [c, d] = ends(j);
  const place = row => [((row[0] - a) / (b - a)) * width, n > 1 ? height - ((row[j] - c) / (d - c)) * height : height / 2];
  line(past.map(place), '--model', 1.5);
  disc(...place(x), 6, '--ink');
  pen.fillStyle = colour('--soft');
  pen.font = '12px system-ui, sans-serif';
  pen.fillText(`across: ${FACTS.names[0]}, up: ${FACTS.names[j]}`, 8, height - 8);
  return place(x);
}

function signals(left, top, width, height) {
  const all = FACTS.names.concat(FACTS.inputs.map(name => name + ' (input)'));
  const rows = all.slice(0, Math.max(1, Math.floor(height / 40))), each = height / rows.length;
  const long = Math.max(120, past.length - 1);
  pen.font = '12px system-ui, sans-serif';
  rows.forEach((name, i) => {
    const [low, high] = ends(i), base = top + (i + 1) * each - 4;
    line([[left, base], [left + width, base]], '--line', 1);
    line(past.map((row, k) => [left + (k / long) * width, base - ((row[i] - low) / (high - low)) * (each - 20)]), i < n ? '--model' : '--push', 1.3);
    pen.fillStyle = colour('--soft');
    const value = past.length ? past[past.length - 1][i].toPrecision(3) : '';
    pen.fillText(`${value}  ${name}`, left + 4, base - each + 16);
  });
  if (rows.length < all.length) pen.fillText(`${all.length - rows.length} more are not drawn`, left + 4, top + height - 6);
}

function draw() {
  const box = picture.getBoundingClientRect(), sharp = window.devicePixelRatio || 1, wide = box.width > 620;
  const height = wide ? 380 : 620;
  if (picture.width !== Math.round(box.width * sharp) || picture.height !== height * sharp) {
    picture.width = Math.round(box.width * sharp);
    picture.height = height * sharp;
    picture.style.height = `${height}px`;
  }
  pen.setTransform(sharp, 0, 0, sharp, 0, 0);
  pen.clearRect(0, 0, box.width, height);
  const size = wide ? [0.55 * box.width, height] : [box.width, 300];
  pen.save();
  pen.beginPath();
  pen.rect(0, 0, ...size);
  pen.clip();
  const at = body(...size);
  if (push) line([at, [at[0] + (push / pushed()) * 90, at[1]]], '--push', 4);
  pen.restore();
  signals(...(wide ? [size[0], 0, box.width - size[0], height] : [0, 300, box.width, 320]));
  find('told').textContent = fell || (push ? `push ${push.toPrecision(2)}` : `${(pace * DT * 2 ** +find('speed').value).toPrecision(2)} s a second`);
}

// The largest push: as far as controls go from one end to the other.
const pushed = () => {
  const [low, high] = range(+find('which').value);
  return high > low ? high - low : Math.max(1, Math.abs(high));
};

function frame(now) {
  if (playing) {
    due += Math.min(now - last, 100) / 1000 * pace * 2 ** +find('speed').value;
    for (let steps = 0; due >= 1 && steps < 200; steps += 1, due -= 1) forward();
    due = Math.min(due, 1);
  }
  last = now;
  draw();
  requestAnimationFrame(frame);
}

let grip = null;
picture.onpointerdown = event => { if (FACTS.inputs.length) { grip = event.clientX; picture.setPointerCapture(event.pointerId); } };
picture.onpointermove = event => { if (grip !== null) push = Math.max(-1, Math.min(1, (event.clientX - grip) / 120)) * pushed(); };
picture.onpointerup = picture.onpointercancel = () => { grip = null; push = 0; };
find('play').onclick = () => { playing = !playing; find('play').textContent = playing ? 'Pause' : 'Play'; };
find('again').onclick = () => begin();
if (!FACTS.policy) find('policy-label').hidden = true;
FACTS.inputs.forEach((name, i) => find('which').add(new Option(name, i)));
if (FACTS.inputs.length < 2) find('which-label').hidden = true;
if (FACTS.inputs.length) Object.assign(picture.style, { touchAction: 'none', cursor: 'crosshair' });
// What inputs are held at where no policy acts.
FACTS.inputs.forEach((name, i) => {
  const [low, high] = range(i);
  if (FACTS.policy || !(high > low)) return;
  const label = document.createElement('label'), slider = document.createElement('input'), value = document.createElement('span');
  slider.type = 'range';
  [slider.min, slider.max, slider.step, slider.value] = [low, high, 'any', held[i]];
  const tell = () => { value.textContent = ` ${held[i].toPrecision(3)}`; };
  slider.oninput = () => { held[i] = +slider.value; tell(); };
  tell();
  label.append(`${name} held at `, slider, value);
  find('held').append(label);
});
find('help').textContent = (FACTS.inputs.length ? `Drag across the picture to push: what you pull is added to ${FACTS.inputs.length > 1 ? 'the input chosen' : FACTS.inputs[0]}. ` : '')
  + 'Sliders change the equations that are simulated' + (FACTS.policy ? '; the policy stays as it was trained.' : '.');

const sliders = [];
FACTS.coefficients.forEach(({ equation, term, fixed }, k) => {
  if (fixed || sliders.length >= 60) return;
  const label = document.createElement('label'), slider = document.createElement('input'), value = document.createElement('span');
  slider.type = 'range';
  [slider.min, slider.max, slider.step] = [-100, 100, 'any'];
  value.className = 'value';
  const tell = () => { value.textContent = `${equation}: ${C[k].toPrecision(4).replace('-', '−')} · ${term}`; };
  slider.oninput = () => { C[k] = identified[k] * (1 + slider.value / 100); tell(); };
  sliders.push(() => { slider.value = 0; C[k] = identified[k]; tell(); });
  label.append(value, slider);
  find('coefficients').append(label);
});
find('identified').onclick = () => sliders.forEach(reset => reset());
sliders.forEach(reset => reset());
begin();
requestAnimationFrame(now => { last = now; frame(now); });
