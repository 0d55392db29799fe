//! What the names of columns say of their roles.

use std::collections::HashSet;

use crate::Suggestion;

/// Words that tell the derivative of a rate, besides those made of words of positions.
const DERIVATIVES: [&str; 9] = ["qdd", "thdd", "xdd", "ddot", "acc", "accel", "acceleration", "accelerations", "wd"];

/// What a name says of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Role {
    Position,
    Rate,
    Input,
}

/// Words that tell a role; of a name of several, the first that is one of them.
const WORDS: [(Role, &[&str]); 3] = [
    (
        Role::Position,
        &[
            "x",
            "y",
            "z",
            "q",
            "th",
            "theta",
            "phi",
            "psi",
            "alpha",
            "beta",
            "angle",
            "angles",
            "position",
            "pos",
            "height",
            "level",
            "displacement",
            "cos",
            "sin",
            "costh",
            "sinth",
            "yaw",
            "pitch",
            "roll",
            "\u{3b8}",
            "\u{3c6}",
            "\u{3c8}",
            "\u{3b1}",
            "\u{3b2}",
        ],
    ),
    (
        Role::Rate,
        &[
            "v",
            "w",
            "vel",
            "velocity",
            "velocities",
            "speed",
            "omega",
            "\u{3c9}",
            "vx",
            "vy",
            "vz",
            "qd",
            "thd",
            "xd",
            "rate",
            "rates",
            "dot",
        ],
    ),
    (
        Role::Input,
        &[
            "u", "f", "a", "action", "control", "force", "input", "torque", "tau", "\u{3c4}", "voltage", "current",
            "effort", "eff", "throttle", "steering", "pwm",
        ],
    ),
];

/// Words that are more likely those of an input than of a state, where nobody said what columns are.
const LIKELY: [&str; 15] = [
    "rudder", "thrust", "delta", "aileron", "elevator", "flap", "brake", "valve", "heater", "heat", "pump", "duty",
    "gas", "inflow", "feed",
];

/// Words of what is set from outside, whatever quantity it is a setting of.
const COMMANDS: [&str; 8] = ["command", "commanded", "cmd", "setpoint", "set", "ref", "reference", "desired"];

/// Those of them that name what a state is to be, not what an actuator does.
const REFERENCES: [&str; 5] = ["setpoint", "set", "ref", "reference", "desired"];

/// Words that tell how a value came about, not what it is.
const HOW: [&str; 12] =
    ["meas", "measured", "filt", "filtered", "raw", "act", "actual", "joint", "motor", "state", "angular", "cart"];

/// Letters and digits of a name, in small letters.
fn words(name: &str) -> Vec<String> {
    let lower = name.to_lowercase();
    let mut words: Vec<String> = vec![String::new()];
    let mut digits = false;
    for c in lower.chars() {
        let digit = c.is_ascii_digit();
        if !c.is_alphanumeric() || digit != digits {
            words.push(String::new());
        }
        if c.is_alphanumeric() {
            words.last_mut().into_iter().for_each(|w| w.push(c));
        }
        digits = digit;
    }
    words.retain(|w| !w.is_empty());
    words
}

/// What a word says, as it is known or made of one of a position: `dq`, `thdot`.
fn says(word: &str) -> Option<Role> {
    let known = |word: &str| WORDS.iter().find(|(_, known)| known.contains(&word)).map(|(role, _)| *role);
    let of = word.strip_suffix("dot").or_else(|| word.strip_prefix('d'));
    let is_made = of.and_then(known) == Some(Role::Position);
    known(word).or(is_made.then_some(Role::Rate))
}

/// What a name says: an input if it is a command (`speed_ref`), a rate if any of its words does (`theta_dot`), an input if a whole word does (`x_force`), else what the first word says that says anything.
fn role(name: &str) -> Option<Role> {
    if is_command(name) {
        return Some(Role::Input);
    }
    let roles: Vec<(String, Role)> =
        words(name).into_iter().filter_map(|word| Some((word.clone(), says(&word)?))).collect();
    let is_rate = |(_, role): &&(String, Role)| *role == Role::Rate;
    let is_input = |(word, role): &&(String, Role)| *role == Role::Input && word.chars().count() > 1;
    let found = roles.iter().find(is_rate).or_else(|| roles.iter().find(is_input)).or(roles.first());
    found.map(|(_, role)| *role)
}

/// Whether `name` is that of a position, and not of a length in space.
pub(crate) fn is_of_a_joint(name: &str) -> bool {
    const LENGTHS: [&str; 6] = ["x", "y", "z", "height", "level", "displacement"];
    role(name) == Some(Role::Position) && !has_word(name, &LENGTHS)
}

/// Whether `name` is that of the derivative of a rate.
pub(crate) fn is_derivative(name: &str) -> bool {
    let made = |word: &str| word.strip_suffix("ddot").or_else(|| word.strip_prefix("dd")).and_then(says);
    words(name).iter().any(|word| DERIVATIVES.contains(&word.as_str()) || made(word) == Some(Role::Position))
}

/// Whether `name` is that of a torque, which turns what it acts on.
pub(crate) fn is_torque(name: &str) -> bool {
    words(name).iter().any(|word| ["torque", "tau", "\u{3c4}", "moment"].contains(&word.as_str()))
}

/// Whether `name` is that of an angle.
pub(crate) fn is_angle(name: &str) -> bool {
    const ANGLES: [&str; 16] = [
        "th", "theta", "phi", "psi", "angle", "angles", "yaw", "pitch", "roll", "heading", "\u{3b8}", "\u{3c6}",
        "\u{3c8}", "alpha", "beta", "azimuth",
    ];
    role(name) != Some(Role::Rate) && words(name).iter().any(|word| ANGLES.contains(&word.as_str()))
}

/// Whether `name` is that of an angle and of nothing else.
pub(crate) fn is_bearing(name: &str) -> bool {
    const BEARINGS: [&str; 7] = ["angle", "angles", "yaw", "pitch", "roll", "heading", "azimuth"];
    is_angle(name) && words(name).iter().any(|word| BEARINGS.contains(&word.as_str()))
}

/// Whether `name` is that of a rate.
pub(crate) fn is_rate(name: &str) -> bool {
    role(name) == Some(Role::Rate)
}

fn has_word(name: &str, known: &[&str]) -> bool {
    words(name).iter().any(|word| known.contains(&word.as_str()))
}

/// Whether `name` is that of what is set from outside.
fn is_command(name: &str) -> bool {
    has_word(name, &COMMANDS)
}

/// What the name of one of `columns` says. A current is a consequence of a voltage or a command that is there, and an input where there is none.
fn role_among(name: &str, columns: &[String]) -> Option<Role> {
    let drives = |other: &String| other != name && (has_word(other, &["voltage", "pwm"]) || is_command(other));
    if has_word(name, &["current"]) && columns.iter().any(drives) { Some(Role::Position) } else { role(name) }
}

/// Whether `name`, that of an input, may be that of what one of `columns`, a command, makes of it: a torque beside a command.
fn may_follow(name: &str, columns: &[String]) -> bool {
    let own = words(name);
    let asks_for_it = |command: &String| {
        let more: Vec<String> = words(command).into_iter().filter(|word| !COMMANDS.contains(&word.as_str())).collect();
        (more.is_empty() && !has_word(command, &REFERENCES)) || more.iter().any(|word| own.contains(word))
    };
    !is_command(name) && columns.iter().filter(|other| is_command(other)).any(asks_for_it)
}

/// The states and inputs among `columns`, if every name tells its role and no two tell the same, and no input may follow another one; `inputs` are known.
pub(crate) fn told(columns: &[String], inputs: &[String]) -> Option<(Vec<String>, Vec<String>)> {
    let mut seen = HashSet::new();
    let (mut states, mut done) = (Vec::new(), inputs.to_vec());
    for name in columns {
        let role = role_among(name, columns)?;
        let what: Vec<String> = words(name).into_iter().filter(|word| !HOW.contains(&word.as_str())).collect();
        if !seen.insert((role, what)) {
            return None;
        }
        match role {
            _ if inputs.contains(name) => {}
            Role::Input if inputs.is_empty() && !may_follow(name, columns) => done.push(name.clone()),
            Role::Input => return None,
            Role::Position | Role::Rate => states.push(name.clone()),
        }
    }
    (!states.is_empty()).then_some((states, done))
}

/// Which of `columns` are likely to be what.
pub(crate) fn suggested(columns: &[String]) -> Suggestion {
    let is_input = |name: &String| role_among(name, columns) == Some(Role::Input) || is_likely(name);
    let (inputs, states) = columns
        .iter()
        .filter(|n| *n != "reward")
        .cloned()
        .partition(|name| is_input(name) && !may_follow(name, columns));
    Suggestion { states, inputs, has_time: false, time_column: None }
}

/// Whether a word of `name` is more likely that of an input.
fn is_likely(name: &str) -> bool {
    words(name).iter().any(|word| LIKELY.contains(&word.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_tell_everything_are_believed_and_others_are_not() {
        let check = |columns: &[&str], expected: Option<(&[&str], &[&str])>| {
            let owned = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
            assert_eq!(told(&owned(columns), &[]), expected.map(|(s, i)| (owned(s), owned(i))), "{columns:?}");
        };
        check(&["position", "velocity", "torque"], Some((&["position", "velocity"], &["torque"])));
        check(&["q1", "q2", "dq1", "dq2", "tau1", "tau2"], Some((&["q1", "q2", "dq1", "dq2"], &["tau1", "tau2"])));
        assert!(
            is_derivative("ddq1")
                && is_derivative("theta_ddot")
                && is_derivative("acc [m/s2]")
                && !is_derivative("dq1")
        );
        check(&["u", "y"], Some((&["y"], &["u"])));
        check(&["th", "thdot", "psi", "dpsi", "u"], Some((&["th", "thdot", "psi", "dpsi"], &["u"])));
        assert!(is_derivative("thddot") && is_derivative("ddpsi") && !is_derivative("thdot") && !is_derivative("add"));
        check(&["current", "speed", "voltage"], Some((&["current", "speed"], &["voltage"])));
        check(&["speed", "motor_current"], Some((&["speed"], &["motor_current"])));
        check(&["current", "speed", "command"], Some((&["current", "speed"], &["command"])));
        check(&["speed", "speed_ref"], Some((&["speed"], &["speed_ref"])));
        check(&["position", "speed", "torque", "command"], None);
        check(
            &["position", "velocity", "voltage", "setpoint"],
            Some((&["position", "velocity"], &["voltage", "setpoint"])),
        );
        check(&["speed", "yaw_rate", "steering_angle", "throttle", "steering_command"], None);
        check(&["pos_meas1", "pos_filt1", "vel_meas1", "tau_meas1"], None);
        check(&["x", "v", "u", "reward"], None);
        check(
            &["x_pos", "x_vel", "x_force", "joint1.pos", "joint1.vel", "joint1.eff"],
            Some((&["x_pos", "x_vel", "joint1.pos", "joint1.vel"], &["x_force", "joint1.eff"])),
        );
        check(&["u"], None);
        let boat = suggested(&["psi", "r", "rudder", "thrust"].map(String::from));
        assert_eq!((boat.states.join(" "), boat.inputs.join(" ")), ("psi r".into(), "rudder thrust".into()));
        let car = suggested(&["speed", "steering_angle", "throttle", "steering_command"].map(String::from));
        assert_eq!(car.states.join(" "), "speed steering_angle");
        assert_eq!(car.inputs.join(" "), "throttle steering_command");
        assert_eq!(told(&["x".into(), "v".into(), "u".into()], &["v".into()]), None);
    }
}
