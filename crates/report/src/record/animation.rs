//! An episode as a moving picture: an SVG, and a few lines of JavaScript that play numbers.

use std::f64::consts::PI;
use std::fmt::Write as _;

use sindyna_record::run::EpisodeTable;

use crate::thin::{range, spread};

/// Frames at most.
const MOST: usize = 600;

/// A shape that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// A cart at state `x` with a pole at angle `θ`, zero upright, turning to the right.
    CartPole { x: usize, angle: usize },
    /// A pole at angle `θ`, zero upright, turning to the left.
    Pendulum { angle: usize },
    /// A car at state `x` on a hill of height sin 3x.
    Car { x: usize },
}

impl Shape {
    /// The shape of the task called `task`, if it is one of ours.
    pub(super) fn of(task: &str, states: &[String]) -> Option<Self> {
        let at = |name: &str| states.iter().position(|s| s.split(" [").next() == Some(name));
        match task {
            "cart-pole" | "cart-pole-swing-up" | "inverted-pendulum" => {
                Some(Self::CartPole { x: at("x")?, angle: at("θ")? })
            }
            "pendulum" => Some(Self::Pendulum { angle: at("θ")? }),
            "mountain-car" => Some(Self::Car { x: at("x")? }),
            _ => None,
        }
    }
}

/// Where the body is: across, up, and its turn in degrees.
type Place = [f64; 3];

/// The animation of `episode`, if there is anything to see.
pub(super) fn html(episode: &EpisodeTable, shape: Shape) -> Option<String> {
    let rows: Vec<_> = spread(&episode.rows.iter().collect::<Vec<_>>(), MOST);
    let position = match shape {
        Shape::CartPole { x, .. } | Shape::Car { x } => Some(x),
        Shape::Pendulum { .. } => None,
    };
    let values = |i: usize| {
        rows.iter().flat_map(move |row| row.states.get(i).into_iter().chain(row.model_states.get(i)).copied())
    };
    let (low, high) = match shape {
        Shape::Car { .. } => (-1.2, 0.6),
        _ => position.and_then(|i| range(values(i))).map_or((-1.0, 1.0), |(low, high)| (low.min(-1.0), high.max(1.0))),
    };
    let across = |x: f64| 60.0 + 340.0 * ((x - low) / (high - low)).clamp(0.0, 1.0);
    let place = |x: &[f64]| -> Option<Place> {
        Some(match shape {
            Shape::CartPole { x: i, angle } => [across(*x.get(i)?), 120.0, x.get(angle)?.to_degrees()],
            Shape::Pendulum { angle } => [230.0, 110.0, -x.get(angle)?.to_degrees()],
            Shape::Car { x: i } => {
                let x = *x.get(i)?;
                // The slope in the drawing, whose sizes are the same in both directions.
                let scale = 340.0 / (high - low);
                [across(x), hill(x), -(3.0 * (3.0 * x).cos() * 60.0).atan2(scale) * 180.0 / PI]
            }
        })
    };
    let real: Vec<Place> = rows.iter().map_while(|row| place(&row.states)).collect();
    let model: Vec<Place> = rows.iter().map_while(|row| place(&row.model_states)).collect();
    if real.len() < 2 {
        return None;
    }
    let times: Vec<f64> = rows.iter().map(|row| row.t).collect();
    let step = (times.get(1)? - times.first()?).abs();
    // A map without seconds is played at thirty steps a second.
    let milliseconds = if step <= 0.25 { (1e3 * step).max(8.0) } else { 33.0 };
    let mut svg = String::from(
        "<svg viewBox=\"0 0 460 230\" role=\"img\" aria-label=\"Animation of one episode of the evaluation\">\n",
    );
    let _ = match shape {
        Shape::CartPole { .. } => writeln!(svg, r#"<line class="grid" x1="40" x2="420" y1="136" y2="136"/>"#),
        Shape::Pendulum { .. } => Ok(()),
        Shape::Car { .. } => {
            let points: Vec<String> = (0..=60)
                .map(|i| low + (high - low) * f64::from(i) / 60.0)
                .map(|x| format!("{:.1},{:.1}", across(x), hill(x)))
                .collect();
            writeln!(svg, r#"<polyline class="measured" points="{}"/>"#, points.join(" "))
        }
    };
    if !model.is_empty() {
        svg += &body(shape, "c0", "model");
    }
    svg += &body(shape, "solid", "real");
    svg += "</svg>\n";
    let numbers = |places: &[Place]| {
        let one = |p: &Place| p.map(|v| format!("{}", (10.0 * v).round() / 10.0)).join(",");
        places.iter().map(one).collect::<Vec<_>>().join(",")
    };
    Some(format!(
        "<figure class=\"animation\">\n{svg}<div class=\"controls\"><button type=\"button\">Play</button>\
         <input type=\"range\" min=\"0\" max=\"{}\" value=\"0\" aria-label=\"step of the episode\"></div>\n\
         <figcaption>First episode of the evaluation. Dark: ground truth; blue: the model's prediction from the same start.</figcaption>\n\
         </figure>\n<script>\n(real => (model => {{\n{SCRIPT}}})([{}]))([{}]);\n</script>\n",
        real.len() - 1,
        numbers(&model),
        numbers(&real),
    )
    .replace("MILLISECONDS", &format!("{milliseconds:.0}")))
}

/// Height of the hill of the mountain car in the drawing.
fn hill(x: f64) -> f64 {
    110.0 - 60.0 * (3.0 * x).sin()
}

/// A body at the origin, that the script moves (`g`) and turns (the `g` inside).
fn body(shape: Shape, class: &str, name: &str) -> String {
    let inside = match shape {
        Shape::CartPole { .. } => {
            format!(
                "<rect class=\"{class} ring\" x=\"-22\" y=\"-9\" width=\"44\" height=\"18\" rx=\"3\"/><g><line class=\"{class} ring\" x1=\"0\" x2=\"0\" y1=\"0\" y2=\"-84\"/></g>"
            )
        }
        Shape::Pendulum { .. } => format!(
            "<g><line class=\"{class} ring\" x1=\"0\" x2=\"0\" y1=\"0\" y2=\"-84\"/><circle class=\"{class} ring\" cx=\"0\" cy=\"-84\" r=\"7\"/></g>"
        ),
        Shape::Car { .. } => {
            format!("<g><rect class=\"{class} ring\" x=\"-14\" y=\"-16\" width=\"28\" height=\"12\" rx=\"4\"/></g>")
        }
    };
    format!("<g data-body=\"{name}\">{inside}</g>\n")
}

/// Plays three numbers a frame: across, up, turn.
const SCRIPT: &str = "\
const figure = document.querySelector('.animation'), slider = figure.querySelector('input');
const button = figure.querySelector('button'), last = real.length / 3 - 1;
let frame = 0, timer = 0;
const put = (name, places) => {
  const body = figure.querySelector(`[data-body=${name}]`), i = 3 * Math.min(frame, places.length / 3 - 1);
  if (!body) return;
  body.setAttribute('transform', `translate(${places[i]} ${places[i + 1]})`);
  body.querySelector('g').setAttribute('transform', `rotate(${places[i + 2]})`);
};
const show = () => { put('model', model); put('real', real); slider.value = frame; };
const pause = () => { clearInterval(timer); timer = 0; button.textContent = 'Play'; };
const next = () => { if (frame >= last) pause(); else { frame += 1; show(); } };
button.onclick = () => {
  if (timer) return pause();
  if (frame >= last) frame = 0;
  button.textContent = 'Pause';
  timer = setInterval(next, MILLISECONDS);
};
slider.oninput = () => { pause(); frame = +slider.value; show(); };
show();
";
