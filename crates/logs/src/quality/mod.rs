//! What in the samples of a log makes it hard to identify anything in it, before that is tried.

mod clipping;
mod feedback;
mod finding;
mod oscillation;
mod signal;
mod spikes;

pub use finding::{At, Finding};

use ndarray::{ArrayView1, s};
use sindyna_core::{Channel, Kind, Spec};

use crate::clock::Gaps;
use crate::recording::{Recording, Source};
use crate::resolution::Step;
use signal::{Clock, Piece, Signal, Trajectory, differences};

/// When each of `recordings` began \[s\].
pub(crate) fn starts(recordings: &[Recording]) -> Vec<f64> {
    recordings.iter().map(|r| r.times.first().copied().unwrap_or(0.0)).collect()
}

/// What is to be said of `recordings`, which began at `starts` and have the channels of `spec`, states as far apart as `steps` say; `gaps` end some of them.
pub(crate) fn findings(
    (recordings, starts): (&[Recording], &[f64]),
    spec: &Spec,
    steps: &[Step],
    gaps: &Gaps,
    sources: &[Source<'_>],
) -> Vec<Finding> {
    let clock = Clock { sources };
    let trajectories: Vec<Trajectory<'_>> = recordings
        .iter()
        .zip(starts)
        .filter(|(recording, _)| recording.lines.len() > 1)
        .map(|(recording, start)| Trajectory { recording, start: *start })
        .collect();
    let states = spec.observation.iter().enumerate().map(|(i, channel)| {
        let step = steps.get(i).and_then(|step| step.size());
        signal(channel, step, &trajectories, |recording| recording.states.slice(s![.., i]))
    });
    // The input of a last row is of no use, and may be missing.
    let inputs =
        spec.control.iter().enumerate().map(|(i, channel)| {
            signal(channel, None, &trajectories, move |recording| recording.inputs.slice(s![..-1, i]))
        });
    let states: Vec<Signal<'_>> = states.collect();
    let inputs: Vec<Signal<'_>> = inputs.collect();
    let mut found: Vec<Finding> = gaps_of(gaps, &clock).into_iter().collect();
    let all = || states.iter().chain(&inputs);
    found.extend(inputs.iter().filter(|u| never_moves(u)).map(|u| Finding::Constant { signal: u.name.to_owned() }));
    // What an input does at its limit is what acts there.
    found.extend(states.iter().flat_map(|signal| clipping::of(signal, &clock)));
    let turns = |i: usize| spec.observation[i].kind == Kind::Angle;
    found.extend(inputs.iter().filter_map(|u| feedback::of(u, &states, turns)));
    found.extend(all().filter_map(|signal| oscillation::of(signal, spec.dt)));
    let switched = states.first().map_or_else(Vec::new, |x| spikes::switched(x, &inputs));
    found.extend(states.iter().filter_map(|x| spikes::of(x, &switched, &clock)));
    found.extend(inputs.iter().filter_map(|u| spikes::of(u, &spikes::switched(u, &[]), &clock)));
    found.extend(states.iter().filter_map(coarse));
    found.extend(states.iter().filter_map(few_values));
    found
}

fn signal<'a>(
    channel: &'a Channel,
    step: Option<f64>,
    trajectories: &'a [Trajectory<'a>],
    values: impl Fn(&'a Recording) -> ArrayView1<'a, f64>,
) -> Signal<'a> {
    let piece = |trajectory: &'a Trajectory<'a>| Piece { trajectory, values: values(trajectory.recording) };
    Signal { name: &channel.name, step, pieces: trajectories.iter().map(piece).collect() }
}

fn gaps_of(gaps: &Gaps, clock: &Clock<'_>) -> Option<Finding> {
    let longest = gaps.all.iter().map(|gap| gap.step).fold(0.0, f64::max);
    let at: Vec<At> = gaps.all.iter().map(|gap| clock.at(gap.table, gap.at)).collect();
    (!at.is_empty()).then_some(Finding::Gaps { longest, at })
}

fn never_moves(signal: &Signal<'_>) -> bool {
    let mut values = signal.pieces.iter().flat_map(|piece| piece.values.iter());
    let first = values.next();
    first.is_some() && values.all(|value| Some(value) == first)
}

/// A state that hardly moves by a step of its lattice from sample to sample.
fn coarse(signal: &Signal<'_>) -> Option<Finding> {
    let step = signal.step?;
    let mut moves: Vec<f64> = signal.pieces.iter().flat_map(|piece| differences(piece.values)).map(f64::abs).collect();
    moves.sort_by(f64::total_cmp);
    let usual = *moves.get(moves.len() / 2)?;
    // Half a step is none at all.
    let moves_at_all = moves.last().is_some_and(|longest| *longest > 0.0);
    (usual < 0.5 * step && moves_at_all).then(|| Finding::Coarse { signal: signal.name.to_owned(), step })
}

/// A state that takes few values, on no even lattice: of several sensors, or in parts.
fn few_values(signal: &Signal<'_>) -> Option<Finding> {
    /// Times that each value is taken by movement, which those of a signal that nobody rounded are not.
    const TAKEN: usize = 10;
    let moves = signal.pieces.iter().flat_map(|piece| differences(piece.values)).filter(|m| *m != 0.0).count();
    let mut values: Vec<u64> =
        signal.pieces.iter().flat_map(|piece| piece.values.iter().map(|v| v.to_bits())).collect();
    values.sort_unstable();
    values.dedup();
    let few = signal.step.is_none() && moves > TAKEN * values.len();
    few.then(|| Finding::FewValues { signal: signal.name.to_owned(), values: values.len() })
}
