//! One setting changed by `KEY=VALUE`.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::Error;

/// Settings by name.
pub(super) type Settings = BTreeMap<String, Setting>;

/// A setting of any kind. TOML's own values end at 2⁶³, and seeds do not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum Setting {
    Switch(bool),
    Natural(u64),
    Whole(i64),
    Fraction(f64),
    Text(String),
    List(Vec<Setting>),
    Group(Settings),
}

/// Numbers that may be left to a rule, and are then absent from a table.
const OPEN: [(&str, &str); 1] = [("sac", "target_entropy")];

/// What leaves such a number to its rule again.
const AUTO: &str = "auto";

/// Changes `document` by `text`, such as `sac.reward_scale=1`.
pub(super) fn change(document: &mut Settings, text: &str) -> Result<(), Error> {
    let value = match text.split_once('=') {
        Some((_, value)) => value.trim(),
        None => return Err(refused(text, "not KEY=VALUE")),
    };
    let key = whole(document, key(text))?;
    let open = OPEN.iter().find(|(group, name)| key.split_once('.') == Some((group, name)));
    if let Some((group, name)) = open {
        if let Some(Setting::Group(group)) = document.get_mut(*group) {
            match value {
                AUTO => group.remove(*name),
                _ => group.insert((*name).to_owned(), read(&Setting::Fraction(0.0), value)),
            };
        }
        return Ok(());
    }
    let slot = slot(document, &key)?;
    *slot = read(slot, value);
    Ok(())
}

/// The setting `text` changes, as `--set` reads it.
pub fn key(text: &str) -> &str {
    text.split('=').next().unwrap_or(text).trim()
}

/// The whole key of the setting called `key`: the name of its group may be left out where only one group has such a setting.
fn whole(document: &Settings, key: &str) -> Result<String, Error> {
    if key.contains('.') || document.contains_key(key) {
        return Ok(key.to_owned());
    }
    let groups = document.iter().filter_map(|(name, setting)| match setting {
        Setting::Group(group) => Some((name, group)),
        _ => None,
    });
    let open = OPEN.iter().filter(|(_, name)| *name == key).map(|(group, _)| (*group).to_owned());
    let found: Vec<String> =
        groups.clone().filter(|(_, group)| group.contains_key(key)).map(|(name, _)| name.clone()).chain(open).collect();
    match &found[..] {
        [group] => Ok(format!("{group}.{key}")),
        [] => {
            let inner = groups.flat_map(|(_, group)| group.keys());
            let known = document.keys().chain(inner).collect::<BTreeSet<_>>().into_iter().cloned().collect();
            Err(Error::UnknownName { what: "setting", name: key.to_owned(), known })
        }
        several => {
            let keys: Vec<String> = several.iter().map(|group| format!("`{group}.{key}`")).collect();
            Err(refused(key, &format!("it could be {}", keys.join(" or "))))
        }
    }
}

/// The place of the setting called `key`, groups before it joined by points.
fn slot<'a>(document: &'a mut Settings, key: &str) -> Result<&'a mut Setting, Error> {
    let mut table = document;
    let mut path = key.split('.').peekable();
    while let Some(name) = path.next() {
        let known: Vec<String> = table.keys().cloned().collect();
        let Some(slot) = table.get_mut(name) else {
            return Err(Error::UnknownName { what: "setting", name: name.to_owned(), known });
        };
        match (slot, path.peek()) {
            (Setting::Group(inner), Some(_)) => table = inner,
            (slot, None) => return Ok(slot),
            (_, Some(_)) => return Err(refused(key, &format!("`{name}` is not a group of settings"))),
        }
    }
    Err(refused(key, "no KEY"))
}

fn refused(text: &str, why: &str) -> Error {
    Error::Override { text: text.to_owned(), why: why.to_owned() }
}

/// `text` as a value of the kind `old` is; a whole number will do for a fraction, and words need no quotes.
fn read(old: &Setting, text: &str) -> Setting {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Line {
        value: Setting,
    }
    let value = toml::from_str(&format!("value = {text}")).map(|Line { value }| value);
    match (old, value) {
        (Setting::Fraction(_), Ok(Setting::Natural(i))) => Setting::Fraction(i as f64),
        (Setting::Fraction(_), Ok(Setting::Whole(i))) => Setting::Fraction(i as f64),
        (Setting::Text(_), _) | (_, Err(_)) => Setting::Text(text.trim_matches('"').to_owned()),
        (_, Ok(value)) => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_group_of_a_setting_may_be_left_out_where_there_is_one() {
        let mut document: Settings =
            toml::from_str("seed = 0\n[sac]\npolyak = 0.005\nlen = 1\n[warmup]\nlen = 2").unwrap();
        change(&mut document, "polyak=0.1").unwrap();
        change(&mut document, "target_entropy=-2").unwrap();
        let Setting::Group(sac) = &document["sac"] else { panic!("a group stays one") };
        assert_eq!((&sac["polyak"], &sac["target_entropy"]), (&Setting::Fraction(0.1), &Setting::Fraction(-2.0)));
        let refusal = change(&mut document, "len=1").unwrap_err().to_string();
        assert!(refusal.contains("it could be `sac.len` or `warmup.len`"), "{refusal}");
        let refusal = change(&mut document, "polyac=1").unwrap_err().to_string();
        assert!(refusal.contains("no setting named `polyac`") && refusal.contains("`polyak`"), "{refusal}");
    }

    #[test]
    fn numbers_left_to_a_rule_are_set_and_left_again() {
        let mut document: Settings = toml::from_str("[sac]\npolyak = 0.005").unwrap();
        let rule = document.clone();
        change(&mut document, "sac.target_entropy=-2").unwrap();
        let Setting::Group(sac) = &document["sac"] else { panic!("a group stays one") };
        assert_eq!(sac["target_entropy"], Setting::Fraction(-2.0));
        change(&mut document, "sac.target_entropy = auto").unwrap();
        assert_eq!(document, rule);
    }
}
