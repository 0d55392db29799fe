//! A program that is spoken to by lines.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use serde::de::DeserializeOwned;

use super::protocol::{Request, answer};

/// How a program that is a system is started and waited for.
#[derive(Debug, Clone)]
pub struct PipeSource {
    /// The program and its arguments; at least the program.
    pub command: Vec<String>,
    /// How long an answer may take.
    pub timeout: Duration,
    /// Set by whoever does not want to wait any longer.
    pub stop: Arc<AtomicBool>,
}

/// Bytes of a line, at most.
const LONGEST: u64 = 1 << 20;

/// How often it is asked whether to go on waiting.
const PAUSE: Duration = Duration::from_millis(50);

/// How long a program has to end by itself.
const PATIENCE: Duration = Duration::from_secs(5);

/// A program that was started, and is ended with this.
pub(super) struct Process {
    child: Child,
    /// Closed once there is nothing more to say.
    to: Option<ChildStdin>,
    lines: Receiver<Result<String, String>>,
    source: PipeSource,
    /// Why nothing more is asked: an answer may still come that nobody waits for.
    broken: Option<String>,
}

impl Process {
    /// Starts it.
    pub(super) fn start(source: &PipeSource) -> Result<Self, String> {
        let (program, arguments) = source.command.split_first().ok_or("no program is named")?;
        let mut command = Command::new(program);
        command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
        // Ctrl-C is for this program, which then asks the other to come to rest.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(|error| format!("it cannot be started: {error}"))?;
        let (sender, lines) = sync_channel(1);
        if let Some(from) = child.stdout.take() {
            std::thread::spawn(move || read(from, &sender));
        }
        let to = child.stdin.take();
        Ok(Self { child, to, lines, source: source.clone(), broken: None })
    }

    /// Its answer to `request`. After what went wrong nothing more is asked.
    pub(super) fn ask<T: DeserializeOwned>(&mut self, request: &Request<'_>) -> Result<T, String> {
        if let Some(why) = &self.broken {
            return Err(why.clone());
        }
        let answered = self.asked(request);
        if let Err(why) = &answered {
            self.broken = Some(why.clone());
        }
        answered
    }

    fn asked<T: DeserializeOwned>(&mut self, request: &Request<'_>) -> Result<T, String> {
        if let Ok(Ok(line)) = self.lines.try_recv() {
            return Err(format!("it sent `{}` without a request; messages for people belong on stderr", line.trim()));
        }
        if self.say(request).is_err() {
            return Err(self.ended(request));
        }
        let line = self.wait(request)?;
        answer(&line, request)
    }

    fn say(&mut self, request: &Request<'_>) -> std::io::Result<()> {
        let Some(to) = &mut self.to else { return Ok(()) };
        let mut line = serde_json::to_string(request)?;
        line.push('\n');
        to.write_all(line.as_bytes())?;
        to.flush()
    }

    /// The next line, where one comes in time.
    fn wait(&mut self, request: &Request<'_>) -> Result<String, String> {
        let begun = Instant::now();
        loop {
            match self.lines.recv_timeout(PAUSE.min(self.source.timeout)) {
                Ok(line) => return line,
                Err(RecvTimeoutError::Disconnected) => return Err(self.ended(request)),
                Err(RecvTimeoutError::Timeout) if self.source.stop.load(Ordering::SeqCst) => {
                    return Err(format!("the wait for its answer to `{}` was interrupted", request.name()));
                }
                Err(RecvTimeoutError::Timeout) if begun.elapsed() >= self.source.timeout => {
                    let seconds = self.source.timeout.as_secs_f64();
                    return Err(format!("it did not answer `{}` within {seconds} s", request.name()));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }

    /// That it ended, and how.
    fn ended(&mut self, request: &Request<'_>) -> String {
        let how = match self.finished(Duration::from_millis(500)) {
            Some(status) => format!("it ended ({status})"),
            None => "it closed its output".into(),
        };
        format!("{how} before it answered `{}`", request.name())
    }

    /// How it ended, if it does `within` so long.
    fn finished(&mut self, within: Duration) -> Option<std::process::ExitStatus> {
        let begun = Instant::now();
        loop {
            match self.child.try_wait() {
                Ok(Some(status)) => return Some(status),
                Err(_) => return None,
                Ok(None) if begun.elapsed() >= within => return None,
                Ok(None) => std::thread::sleep(Duration::from_millis(5)),
            }
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // One that is gone already needs no word.
        let _ = self.say(&Request::Close);
        self.to = None;
        if self.finished(PATIENCE).is_none() {
            self.kill();
            let _ = self.child.wait();
        }
    }
}

impl Process {
    /// Ends it and what it started.
    #[cfg(unix)]
    fn kill(&mut self) {
        let group = rustix::process::Pid::from_child(&self.child);
        let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
    }

    #[cfg(not(unix))]
    fn kill(&mut self) {
        let _ = self.child.kill();
    }
}

/// Reads lines until there are no more, or nobody wants them.
fn read(from: ChildStdout, sender: &SyncSender<Result<String, String>>) {
    let mut from = BufReader::new(from);
    loop {
        let mut line = Vec::new();
        let told = match from.by_ref().take(LONGEST).read_until(b'\n', &mut line) {
            Ok(0) => return,
            Ok(_) if line.ends_with(b"\n") => Ok(String::from_utf8_lossy(&line).into_owned()),
            Ok(_) if line.len() as u64 == LONGEST => Err(format!("it sent a line of more than {LONGEST} bytes")),
            // It ended in the middle of a line.
            Ok(_) => return,
            Err(error) => Err(format!("its output cannot be read: {error}")),
        };
        let ended = told.is_err();
        if sender.send(told).is_err() || ended {
            return;
        }
    }
}
