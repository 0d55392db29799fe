//! Messages, each with named numbers, as the rows of a table.

use std::collections::HashMap;
use std::path::Path;

use serde_json::Value;

use super::budget::MOST_NUMBERS;
use super::format::Format;
use crate::LogError;
use crate::column::Column;
use crate::table::Table;
use crate::values::Values;

/// Numbers of a message that are read, and lists within lists that are followed.
const MOST: usize = 100_000;
const DEEPEST: usize = 8;

/// Messages so far.
#[derive(Debug, Default)]
pub(super) struct Messages {
    /// When they were logged, and when they were made \[ns\].
    logged: Vec<u64>,
    made: Vec<i64>,
    numbers: HashMap<String, usize>,
    /// Name, and the numbers with their messages.
    columns: Vec<(String, Vec<(usize, f64)>)>,
}

impl Messages {
    fn begin(&mut self, logged: u64, made: i64) {
        self.logged.push(logged);
        self.made.push(made);
    }

    /// Sets `name` in the last message.
    fn set(&mut self, name: &str, value: f64) -> Result<(), String> {
        let number = match self.numbers.get(name) {
            Some(number) => *number,
            None if self.columns.len() >= MOST => return Err(format!("more than {MOST} numbers have names")),
            None => {
                self.numbers.insert(name.to_owned(), self.columns.len());
                self.columns.push((name.to_owned(), Vec::new()));
                self.columns.len() - 1
            }
        };
        self.columns[number].1.push((self.logged.len().saturating_sub(1), value));
        Ok(())
    }

    /// Sets what a `sensor_msgs/JointState` says of each joint.
    fn set_joints(&mut self, names: &[String], values: [(&str, &[f64]); 3]) -> Result<(), String> {
        for (what, values) in values {
            if !values.is_empty() && values.len() != names.len() {
                return Err(format!("{} joints have names and {} a value of `{what}`", names.len(), values.len()));
            }
            names.iter().zip(values).try_for_each(|(name, value)| self.set(&format!("{what}_{name}"), *value))?;
        }
        Ok(())
    }

    /// The table that they make: times first.
    pub(super) fn table(self, path: &Path) -> Result<Table, LogError> {
        if self.columns.is_empty() {
            return Err(Format::Mcap.failed(path, "its messages have no numbers".into()));
        }
        let rows = self.logged.len();
        if rows.saturating_mul(self.columns.len()) > MOST_NUMBERS {
            let reason = format!("{} numbers in {rows} messages are more than fit in memory", self.columns.len());
            return Err(Format::Mcap.failed(path, reason));
        }
        let stamped = self.made.iter().any(|t| *t != 0);
        let time = |name: &str, values| (Column { name: name.into(), unit: "ns".into() }, values);
        let made = stamped.then(|| time("stamp", Values::I64(self.made)));
        // A time that the messages have themselves comes before that of whoever recorded them.
        let logged = [time("log_time", Values::U64(self.logged))];
        let taken = |name: &str| ["log_time", "stamp"].contains(&name);
        let columns = self.columns.into_iter().map(|(name, told)| {
            let mut values = vec![f64::NAN; rows];
            told.into_iter().for_each(|(row, value)| values[row] = value);
            let name = if taken(&name) { format!("{name}_") } else { name };
            (Column::new(&name), Values::F64(values))
        });
        Ok(Table::of_values(path, made.into_iter().chain(columns).chain(logged).collect(), rows, Vec::new()))
    }
}

/// A `sensor_msgs/JointState` in CDR.
pub(super) fn joint_state(data: &[u8], messages: &mut Messages, logged: u64) -> Result<(), String> {
    let mut cdr = Cdr::new(data)?;
    let (seconds, nanoseconds) = (cdr.word()?.cast_signed(), cdr.word()?);
    cdr.text()?;
    messages.begin(logged, i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds));
    let count = cdr.count(5)?;
    let names = (0..count).map(|_| cdr.text()).collect::<Result<Vec<_>, _>>()?;
    let (position, velocity, effort) = (cdr.doubles()?, cdr.doubles()?, cdr.doubles()?);
    messages.set_joints(&names, [("position", &position), ("velocity", &velocity), ("effort", &effort)])
}

/// The numbers of an object in JSON, those within others by names with a dot, those of a list by their place from 1.
pub(super) fn json(data: &[u8], messages: &mut Messages, logged: u64) -> Result<(), String> {
    let value: Value = serde_json::from_slice(data).map_err(|e| e.to_string())?;
    let Value::Object(object) = &value else { return Err("it is not an object".into()) };
    let of = |key: &str| value.pointer(key).and_then(Value::as_i64).unwrap_or(0);
    let nanoseconds = of("/header/stamp/nanosec") + of("/header/stamp/nsec");
    messages.begin(logged, of("/header/stamp/sec").saturating_mul(1_000_000_000).saturating_add(nanoseconds));
    let list = |key: &str| -> Option<&Vec<Value>> { object.get(key)?.as_array() };
    let names = list("name").and_then(|names| names.iter().map(|n| n.as_str().map(str::to_owned)).collect());
    if let (Some(names), Some(_)) = (names, list("position")) {
        let names: Vec<String> = names;
        let numbers = |key: &str| -> Result<Vec<f64>, String> {
            let values = list(key).map_or(&[][..], Vec::as_slice);
            values
                .iter()
                .map(|v| v.as_f64().ok_or_else(|| format!("`{key}` holds something that is not a number")))
                .collect()
        };
        let (position, velocity, effort) = (numbers("position")?, numbers("velocity")?, numbers("effort")?);
        return messages.set_joints(&names, [("position", &position), ("velocity", &velocity), ("effort", &effort)]);
    }
    object.iter().filter(|(key, _)| *key != "header").try_for_each(|(key, value)| flat(messages, key, value, DEEPEST))
}

/// Sets the numbers in `value`, which is called `name`.
fn flat(messages: &mut Messages, name: &str, value: &Value, depth: usize) -> Result<(), String> {
    let depth = depth.checked_sub(1).ok_or_else(|| format!("`{name}` is nested too deeply"))?;
    match value {
        Value::Number(number) => messages.set(name, number.as_f64().unwrap_or(f64::NAN)),
        Value::Bool(is) => messages.set(name, f64::from(u8::from(*is))),
        Value::Object(object) => {
            object.iter().try_for_each(|(key, value)| flat(messages, &format!("{name}.{key}"), value, depth))
        }
        Value::Array(list) => {
            list.iter().enumerate().try_for_each(|(i, value)| flat(messages, &format!("{name}{}", i + 1), value, depth))
        }
        Value::Null | Value::String(_) => Ok(()),
    }
}

/// Bytes in the Common Data Representation: every number stands at a multiple of its size, after four bytes that tell their order.
struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
    big: bool,
}

impl<'a> Cdr<'a> {
    fn new(data: &'a [u8]) -> Result<Self, String> {
        let (head, bytes) = data.split_at_checked(4).ok_or("it is truncated")?;
        match head[..2] {
            [0, order @ (0 | 1)] => Ok(Self { bytes, at: 0, big: order == 0 }),
            _ => Err(format!("its encoding is {:#04x}{:02x}; plain CDR is read", head[0], head[1])),
        }
    }

    fn take(&mut self, size: usize, align: usize) -> Result<&'a [u8], String> {
        let begin = self.at.next_multiple_of(align);
        let part = self.bytes.get(begin..).and_then(|rest| rest.get(..size)).ok_or("it is truncated")?;
        self.at = begin + size;
        Ok(part)
    }

    fn word(&mut self) -> Result<u32, String> {
        let bytes = self.take(4, 4)?;
        let bytes = [bytes[0], bytes[1], bytes[2], bytes[3]];
        Ok(if self.big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// A number of things of `size` bytes or more each, which are there.
    fn count(&mut self, size: usize) -> Result<usize, String> {
        let count = self.word()? as usize;
        let left = self.bytes.len().saturating_sub(self.at);
        if count.saturating_mul(size) > left {
            Err(format!("it declares {count} elements where {left} bytes are left"))
        } else {
            Ok(count)
        }
    }

    fn text(&mut self) -> Result<String, String> {
        let size = self.count(1)?;
        let text = String::from_utf8_lossy(self.take(size, 1)?).into_owned();
        Ok(text.trim_end_matches('\0').to_owned())
    }

    fn doubles(&mut self) -> Result<Vec<f64>, String> {
        let count = self.count(8)?;
        if count == 0 {
            return Ok(Vec::new());
        }
        let bytes = self.take(8 * count, 8)?;
        let of = |b: &[u8]| {
            let b = [b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]];
            if self.big { f64::from_be_bytes(b) } else { f64::from_le_bytes(b) }
        };
        Ok(bytes.chunks_exact(8).map(of).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(messages: Messages) -> Vec<Vec<String>> {
        let table = messages.table(Path::new("log.mcap")).unwrap();
        let names = table.columns().iter().map(|c| c.name.clone()).collect();
        let rows = table.rows().map(|(_, cells)| cells.iter().map(ToString::to_string).collect());
        [names].into_iter().chain(rows).collect()
    }

    #[test]
    fn joints_are_told_by_their_names_whatever_their_order() {
        // As rclpy serialises it: two joints, no velocities.
        let mut data = vec![0, 1, 0, 0];
        let put = |bytes: &[u8], data: &mut Vec<u8>| data.extend(bytes);
        put(&3_u32.to_le_bytes(), &mut data);
        put(&500_u32.to_le_bytes(), &mut data);
        put(&[5, 0, 0, 0], &mut data);
        put(b"base\0\0\0\0", &mut data);
        put(&[2, 0, 0, 0, 2, 0, 0, 0], &mut data);
        put(b"a\0\0\0", &mut data);
        put(&[2, 0, 0, 0], &mut data);
        put(b"b\0\0\0", &mut data);
        put(&[2, 0, 0, 0], &mut data);
        // Doubles stand at a multiple of eight, which does not count the four bytes of encoding.
        put(&[0; 4], &mut data);
        [0.5_f64, -1.0].iter().for_each(|v| put(&v.to_le_bytes(), &mut data));
        put(&[0, 0, 0, 0], &mut data);
        put(&[0, 0, 0, 0], &mut data);
        let mut messages = Messages::default();
        joint_state(&data, &mut messages, 7).unwrap();
        let swapped = br#"{"header": {"stamp": {"sec": 3, "nanosec": 600}}, "name": ["b", "a"], "position": [-2, 1]}"#;
        json(swapped, &mut messages, 9).unwrap();
        assert_eq!(
            told(messages),
            [
                ["stamp", "position_a", "position_b", "log_time"],
                ["3000000500", "0.5", "-1", "7"],
                ["3000000600", "1", "-2", "9"]
            ]
        );
        for end in 0..data.len() - 4 {
            assert!(joint_state(&data[..end], &mut Messages::default(), 0).is_err(), "{end}");
        }
        let mut many = data.clone();
        many[24..28].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(joint_state(&many, &mut Messages::default(), 0).unwrap_err().contains("4294967295"));
    }

    #[test]
    fn objects_are_flat_and_what_is_missing_stays_so() {
        let mut messages = Messages::default();
        json(br#"{"q": {"left": 1, "note": "x"}, "u": [0.5, true]}"#, &mut messages, 1).unwrap();
        json(br#"{"w": 2.5, "u": [1]}"#, &mut messages, 2).unwrap();
        assert_eq!(
            told(messages),
            [["q.left", "u1", "u2", "w", "log_time"], ["1", "0.5", "1", "", "1"], ["", "1", "", "2.5", "2"]]
        );
        let deep = format!("{{\"a\": {}1{}}}", "[".repeat(100), "]".repeat(100));
        for (bad, says) in [("[1]", "not an object"), ("{\"a\":", "EOF"), (deep.as_str(), "nested too deeply")] {
            let failure = json(bad.as_bytes(), &mut Messages::default(), 0).unwrap_err();
            assert!(failure.contains(says), "{failure}");
        }
    }
}
