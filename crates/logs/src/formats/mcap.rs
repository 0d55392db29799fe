//! MCAP, the recordings of ROS 2: one topic of `sensor_msgs/JointState` (CDR) or of messages in JSON.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use mcap::read::LinearReader;
use mcap::records::Record;

use super::budget::Budget;
use super::format::Format;
use super::messages::{Messages, joint_state, json};
use crate::LogError;
use crate::table::Table;

/// The messages of `topic`, or of the only one that can be read, as a table.
pub(super) fn read(path: &Path, bytes: &[u8], topic: Option<&str>) -> Result<Table, LogError> {
    let failed = |reason: String| Format::Mcap.failed(path, reason);
    let (mut budget, mut file) = (Budget::default(), File::default());
    for record in LinearReader::new(bytes).map_err(|e| failed(e.to_string()))? {
        let record = record.map_err(|e| failed(e.to_string()))?;
        if let Record::Chunk { header, data } = record {
            let chunk = unpacked(&header.compression, data, &mut budget).map_err(failed)?;
            for record in LinearReader::sans_magic(&chunk) {
                file.take(record.map_err(|e| failed(e.to_string()))?);
            }
        } else {
            file.take(record);
        }
    }
    file.table(path, topic)
}

/// The records in a chunk.
fn unpacked<'a>(compression: &str, data: Cow<'a, [u8]>, budget: &mut Budget) -> Result<Cow<'a, [u8]>, String> {
    match compression {
        "" => Ok(data),
        "zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(Cursor::new(data)).map_err(|e| e.to_string())?;
            budget.read(decoder).map(Cow::Owned)
        }
        "lz4" => budget.read(lz4_flex::frame::FrameDecoder::new(Cursor::new(data))).map(Cow::Owned),
        other => Err(format!("it is compressed by `{other}`")),
    }
}

/// What was seen of the file so far.
#[derive(Default)]
struct File {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, mcap::records::Channel>,
    /// Time and content of the messages of each channel.
    messages: BTreeMap<u16, Vec<(u64, Vec<u8>)>>,
}

/// How messages are written.
type Decoder = fn(&[u8], &mut Messages, u64) -> Result<(), String>;

impl File {
    fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                self.channels.insert(channel.id, channel);
            }
            Record::Message { header, data } => {
                self.messages.entry(header.channel_id).or_default().push((header.log_time, data.into_owned()));
            }
            _ => {}
        }
    }

    /// How the messages of `channel` are written, if that is known.
    fn decoder(&self, channel: &mcap::records::Channel) -> Option<Decoder> {
        let schema = self.schemas.get(&channel.schema_id).map_or("", String::as_str);
        match channel.message_encoding.as_str() {
            "json" => Some(json),
            "cdr" if ["sensor_msgs/msg/JointState", "sensor_msgs/JointState"].contains(&schema) => Some(joint_state),
            _ => None,
        }
    }

    fn table(self, path: &Path, topic: Option<&str>) -> Result<Table, LogError> {
        let readable: BTreeMap<&str, Decoder> = self
            .channels
            .values()
            .filter(|channel| self.messages.contains_key(&channel.id))
            .filter_map(|channel| Some((channel.topic.as_str(), self.decoder(channel)?)))
            .collect();
        let topics = || readable.keys().map(|topic| (*topic).to_owned()).collect::<Vec<_>>();
        let path_of = || path.to_owned();
        let (topic, decoder) = match (topic, readable.len()) {
            (Some(named), _) => {
                let unknown = || LogError::UnknownTopic { path: path_of(), topic: named.to_owned(), topics: topics() };
                readable.get_key_value(named).ok_or_else(unknown)?
            }
            (None, 0) => {
                let of = |channel: &mcap::records::Channel| {
                    let schema = self.schemas.get(&channel.schema_id).map_or("no schema", String::as_str);
                    (channel.topic.clone(), format!("has {} in {}", schema, channel.message_encoding))
                };
                return Err(LogError::NoArrays { path: path_of(), arrays: self.channels.values().map(of).collect() });
            }
            (None, 1) => readable.first_key_value().ok_or(LogError::NoLog)?,
            (None, _) => return Err(LogError::SeveralTopics { path: path_of(), topics: topics() }),
        };
        let of_topic = self.channels.values().filter(|channel| channel.topic == *topic);
        let mut all: Vec<&(u64, Vec<u8>)> = of_topic.filter_map(|c| self.messages.get(&c.id)).flatten().collect();
        all.sort_by_key(|(time, _)| *time);
        let mut messages = Messages::default();
        for (i, (time, data)) in all.into_iter().enumerate() {
            decoder(data, &mut messages, *time)
                .map_err(|why| Format::Mcap.failed(path, format!("message {} of `{topic}`: {why}", i + 1)))?;
        }
        messages.table(path)
    }
}
