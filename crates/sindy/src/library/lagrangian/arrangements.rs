//! How bodies may hang on each other: a smaller library for each arrangement.

use super::wave::Waves;
use super::{Joints, Lagrangian, Parameter};

/// Arrangements beyond which only one is tried: joints as they are declared, each link on the one before it.
const MOST: usize = 120;

/// What the coordinate of a joint is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Motion {
    Slides,
    Turns,
}

impl Lagrangian {
    /// Bodies in a plane, for every way in which the joints may be arranged: links turn by their own coordinate, or by that and the angle of an earlier link.
    ///
    /// In angles of links φ the kinetic energy of such bodies has only waves of φᵢ − φⱼ, and of φᵢ for what slides, the potential energy only waves of
    /// φᵢ: of n joints there are about 2 n² unknowns, where [`Lagrangian::new`] has 2 n⁴.
    pub(crate) fn arrangements(joints: &Joints) -> Vec<Self> {
        Self::arranged(joints, |motion| motion.contains(&Motion::Turns))
    }

    /// The same, and bodies of which none turns.
    pub(crate) fn all_arrangements(joints: &Joints) -> Vec<Self> {
        Self::arranged(joints, |_| true)
    }

    fn arranged(joints: &Joints, may_be: impl Fn(&[Motion]) -> bool) -> Vec<Self> {
        let n = joints.pairs.len();
        let declared: Vec<Motion> =
            (0..n).map(|i| if joints.turns(i) { Motion::Turns } else { Motion::Slides }).collect();
        let mut all: Vec<(Vec<Motion>, Vec<Vec<i32>>)> = motions(joints, &declared)
            .into_iter()
            .filter(|motion| may_be(motion))
            .flat_map(|motion| links(&motion).into_iter().map(move |links| (motion.clone(), links)))
            .collect();
        if all.len() > MOST {
            all = vec![(declared.clone(), in_a_row(&declared))];
        }
        all.into_iter().map(|(motion, links)| Self::of_links(joints, &motion, links)).collect()
    }

    fn of_links(joints: &Joints, motion: &[Motion], links: Vec<Vec<i32>>) -> Self {
        let n = joints.pairs.len();
        let mut waves = Waves::new(joints.pairs.iter().map(|(q, _)| *q).collect());
        let mut parameters = Vec::new();
        let turning = |i: usize| motion[i] == Motion::Turns;
        for i in 0..n {
            for j in i..n {
                parameters.push(Parameter::Inertia(0, i, j));
                let angle: Vec<i32> = (0..n)
                    .map(|q| {
                        let of = |l: usize| if turning(l) { links[l][q] } else { 0 };
                        if turning(i) { of(i) - of(j) } else { of(j) }
                    })
                    .collect();
                if i != j && angle.iter().any(|k| *k != 0) {
                    parameters.extend(waves.of(&angle).map(|w| Parameter::Inertia(w, i, j)));
                }
            }
        }
        for i in (0..n).filter(|&i| turning(i)) {
            parameters.extend(waves.of(&links[i]).map(Parameter::Potential));
        }
        parameters.extend(joints.forces());
        Self::with(joints, links, waves, parameters)
    }
}

/// What each joint may do: what is declared, and without a declaration either.
fn motions(joints: &Joints, declared: &[Motion]) -> Vec<Vec<Motion>> {
    declared.iter().enumerate().fold(vec![Vec::new()], |all, (i, own)| {
        let either: &[Motion] = if joints.turns(i) { &[Motion::Turns] } else { &[*own, Motion::Turns] };
        all.iter().flat_map(|begun| either.iter().map(|one| [&begun[..], &[*one]].concat())).collect()
    })
}

/// φ = S q, row by row, for all arrangements: a link that turns by its own coordinate, or by that, with either sign, and the angle of an earlier one.
fn links(motion: &[Motion]) -> Vec<Vec<Vec<i32>>> {
    let n = motion.len();
    let own = |i: usize| (0..n).map(|q| i32::from(q == i)).collect::<Vec<i32>>();
    (0..n).fold(vec![Vec::new()], |all: Vec<Vec<Vec<i32>>>, i| {
        let next = |begun: &Vec<Vec<i32>>| {
            let mut rows = vec![own(i)];
            for before in (0..i).rev().filter(|&before| motion[i] == Motion::Turns && motion[before] == Motion::Turns) {
                for sign in [1, -1] {
                    rows.push(begun[before].iter().zip(own(i)).map(|(of, own)| of + sign * own).collect());
                }
            }
            rows.into_iter().map(|row| [&begun[..], &[row]].concat()).collect::<Vec<_>>()
        };
        all.iter().flat_map(next).collect()
    })
}

/// Each link that turns on the one before it.
fn in_a_row(motion: &[Motion]) -> Vec<Vec<i32>> {
    let n = motion.len();
    let is_in = |i: usize, q: usize| q == i || (q < i && motion[i] == Motion::Turns && motion[q] == Motion::Turns);
    (0..n).map(|i| (0..n).map(|q| i32::from(is_in(i, q))).collect()).collect()
}
