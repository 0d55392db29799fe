//! Where the controls can lead: a search outward from a state, one cell of the state space after the other.

use std::collections::HashSet;

use rayon::prelude::*;
use sindyna_core::Space;

use super::goal::Goal;
use super::plant::{Plant, unused};

/// Change of the state over which a control is held, in scales.
const STRIDE: f64 = 0.25;

/// States that are followed at a time, at most.
const WIDTH: usize = 2_000;

/// Part of them that is nearest to a goal.
const NEAR: f64 = 0.9;

/// Steps of the model in one search.
const BUDGET: usize = 400_000;

/// Steps for which a control is held, at most.
const LONGEST: usize = 25;

/// A state that was reached.
struct Node {
    x: Vec<f64>,
    /// Its place among all nodes; where it came from, and under what.
    parent: usize,
    control: Choice,
    earned: f64,
    ended: bool,
    /// Whether it is yet in the cell of its parent: what was held is held on.
    within: bool,
}

/// What is held from a node on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Choice {
    /// A control of the list.
    Held(usize),
    /// The regulator of the first goal.
    Regulated,
}

/// Cells are entered in the order of time, each once: so every one is reached about as early as it can be.
///
/// # References
/// Barraquand, Latombe (1993), Algorithmica 10, "Nonholonomic multibody mobile robots: controllability and motion planning in the presence of
/// obstacles", §5: the same search, for wheeled robots.
pub(crate) struct Front<'a> {
    plant: &'a Plant,
    goals: &'a [Goal],
    /// Width of a cell, in scales.
    width: f64,
    /// Steps for which each is held.
    hold: usize,
    controls: Vec<Vec<f64>>,
    nodes: Vec<Node>,
    /// Nodes that were reached last, and go on.
    front: Vec<usize>,
    /// Nodes that were reached last.
    new: std::ops::Range<usize>,
    cells: HashSet<Vec<i32>>,
    left: usize,
    depth: usize,
}

impl<'a> Front<'a> {
    /// From `x`, through cells of `width` scales.
    pub(crate) fn new(plant: &'a Plant, goals: &'a [Goal], x: &[f64], width: f64) -> Self {
        let start = Node {
            x: x.to_vec(),
            parent: usize::MAX,
            control: Choice::Held(0),
            earned: 0.0,
            ended: false,
            within: false,
        };
        let controls = match &plant.spec().action_space {
            Space::Discrete { controls } => controls.rows().into_iter().map(|row| row.to_vec()).collect(),
            Space::Box { .. } => corners(plant),
        };
        Self {
            plant,
            goals,
            width,
            hold: (STRIDE / plant.pace).clamp(1.0, LONGEST as f64) as usize,
            controls,
            nodes: vec![start],
            front: vec![0],
            new: 0..1,
            cells: HashSet::from([cell(plant, x, width)]),
            left: BUDGET,
            depth: 0,
        }
    }

    /// Steps from the start to the nodes that were reached last.
    pub(crate) fn length(&self) -> usize {
        self.depth * self.hold
    }

    /// Goes on by as many steps as a control is held; whether anything new was reached.
    pub(crate) fn advance(&mut self) -> bool {
        let all: Vec<Choice> = (0..self.controls.len())
            .map(Choice::Held)
            .chain((!self.goals.is_empty()).then_some(Choice::Regulated))
            .collect();
        let choices = |node: usize| {
            let Node { within, control, .. } = &self.nodes[node];
            if *within { std::slice::from_ref(control) } else { &all[..] }
        };
        let cost = self.front.iter().map(|node| choices(*node).len() * self.hold).sum::<usize>();
        if cost == 0 || cost > self.left || self.plant.stopped() {
            return false;
        }
        self.left -= cost;
        let reached: Vec<Vec<Node>> = self
            .front
            .par_iter()
            .map(|&parent| choices(parent).iter().filter_map(|&choice| self.follow(parent, choice)).collect())
            .collect();
        let first = self.nodes.len();
        for mut node in reached.into_iter().flatten() {
            let place = cell(self.plant, &node.x, self.width);
            node.within = place == cell(self.plant, &self.nodes[node.parent].x, self.width);
            if node.within || self.cells.insert(place) {
                self.nodes.push(node);
            }
        }
        self.new = first..self.nodes.len();
        self.front = self.new.clone().filter(|node| !self.nodes[*node].ended).collect();
        if self.front.len() > WIDTH {
            self.thin();
        }
        self.depth += 1;
        !self.new.is_empty()
    }

    /// Leaves out all but as many nodes as are followed: those nearest to a goal, and some from everywhere. Others may enter the cells of those left out.
    fn thin(&mut self) {
        let away = |node: &usize| {
            let x = &self.nodes[*node].x;
            self.goals.iter().map(|goal| goal.distance(x)).fold(f64::INFINITY, f64::min)
        };
        let mut order: Vec<(f64, usize)> = self.front.iter().map(|node| (away(node), *node)).collect();
        order.sort_by(|one, other| one.0.total_cmp(&other.0));
        let near = if self.goals.is_empty() { 0 } else { (NEAR * WIDTH as f64) as usize };
        let step = (order.len() - near) as f64 / (WIDTH - near) as f64;
        let from_everywhere = (0..WIDTH - near).map(|i| order[near + (i as f64 * step) as usize].1);
        let mut kept: Vec<usize> = order[..near].iter().map(|(_, node)| *node).chain(from_everywhere).collect();
        kept.sort_unstable();
        for node in &self.front {
            if kept.binary_search(node).is_err() && !self.nodes[*node].within {
                self.cells.remove(&cell(self.plant, &self.nodes[*node].x, self.width));
            }
        }
        self.front = kept;
    }

    /// The node that is reached from `parent` under `choice`; `None` where the model diverges or a position leaves its bounds.
    fn follow(&self, parent: usize, choice: Choice) -> Option<Node> {
        let Node { x, earned, .. } = &self.nodes[parent];
        let (mut x, mut next, mut rng) = (x.clone(), vec![0.0; x.len()], unused());
        let mut node = Node { x: Vec::new(), parent, control: choice, earned: *earned, ended: false, within: false };
        for _ in 0..self.hold {
            let u = self.control(choice, &x);
            let stepped = self.plant.step(&x, &u, &mut rng, &mut next)?;
            if self.plant.is_outside(&next) {
                return None;
            }
            node.earned += stepped.reward;
            std::mem::swap(&mut x, &mut next);
            if stepped.ended {
                node.ended = true;
                break;
            }
        }
        Some(Node { x, ..node })
    }

    fn control(&self, choice: Choice, x: &[f64]) -> Vec<f64> {
        match choice {
            Choice::Held(i) => self.controls[i].clone(),
            Choice::Regulated => self.goals[0].control(self.plant, x),
        }
    }

    /// The `count` nodes reached last that are nearest to `goal`, each with its distance and the controls that lead there.
    pub(crate) fn nearest(&self, goal: &Goal, count: usize, most: f64) -> Vec<(f64, Vec<Vec<f64>>)> {
        let mut near: Vec<(f64, usize)> = self
            .new
            .clone()
            .filter(|node| !self.nodes[*node].ended)
            .map(|node| (goal.distance(&self.nodes[node].x), node))
            .filter(|(distance, _)| *distance <= most)
            .collect();
        near.sort_by(|one, other| one.0.total_cmp(&other.0));
        near.truncate(count);
        near.into_iter().map(|(distance, node)| (distance, self.controls_to(node))).collect()
    }

    /// The controls to that of the nodes reached last that earned most; of those where the episode ended, if `ended`.
    pub(crate) fn richest(&self, ended: bool) -> Option<Vec<Vec<f64>>> {
        let nodes = self.new.clone().filter(|node| self.nodes[*node].ended == ended);
        let best = nodes.max_by(|&one, &other| self.nodes[one].earned.total_cmp(&self.nodes[other].earned))?;
        Some(self.controls_to(best))
    }

    fn controls_to(&self, mut node: usize) -> Vec<Vec<f64>> {
        let mut choices = Vec::new();
        while self.nodes[node].parent != usize::MAX {
            choices.push((self.nodes[node].parent, self.nodes[node].control));
            node = self.nodes[node].parent;
        }
        let (mut rng, mut next, mut controls) = (unused(), vec![0.0; self.nodes[0].x.len()], Vec::new());
        for (parent, choice) in choices.into_iter().rev() {
            let mut x = self.nodes[parent].x.clone();
            for _ in 0..self.hold {
                let u = self.control(choice, &x);
                let Some(stepped) = self.plant.step(&x, &u, &mut rng, &mut next) else { break };
                controls.push(u);
                std::mem::swap(&mut x, &mut next);
                if stepped.ended {
                    break;
                }
            }
        }
        controls
    }
}

/// Every combination of lowest, middle and highest controls.
fn corners(plant: &Plant) -> Vec<Vec<f64>> {
    let mut all = vec![Vec::new()];
    for (j, middle) in plant.middle().into_iter().enumerate() {
        let ends = [plant.low[j], middle, plant.high[j]];
        all = all.iter().flat_map(|begun| ends.map(|end| [begun.as_slice(), &[end]].concat())).collect();
    }
    all
}

/// The cell of x: of the states that controls change, `width` scales wide; angles within a turn.
fn cell(plant: &Plant, x: &[f64], width: f64) -> Vec<i32> {
    let each = (0..x.len()).filter(|i| plant.moved[*i]);
    each.map(|i| {
        let value = if plant.turns[i] { x[i].rem_euclid(std::f64::consts::TAU) } else { x[i] };
        (value / (width * plant.scales[i])).floor() as i32
    })
    .collect()
}
