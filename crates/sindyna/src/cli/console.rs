//! Where a command writes, in which form, and how much of it.

use std::io::Write as _;

use anstream::{AutoStream, ColorChoice};
use clap::ValueEnum;

use super::answer::Answer;
use super::failure::Failure;

/// What every command understands about its output.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct Console {
    /// Print one JSON object on stdout and nothing else (docs/json.md)
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Print no progress on stderr
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Also print threads, instructions and the equations of every fit on stderr
    #[arg(long, short, global = true, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
    /// Colours on stderr; `auto` is a terminal without NO_COLOR
    #[arg(long, value_enum, value_name = "WHEN", default_value_t = Color::Auto, global = true)]
    pub(crate) color: Color,
}

/// When messages have colours.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Color {
    #[default]
    Auto,
    Always,
    Never,
}

impl Console {
    /// What the words of a command line that cannot be understood ask for.
    pub(crate) fn guessed(words: &[String]) -> Self {
        let words: Vec<&str> = words.iter().map(String::as_str).take_while(|word| *word != "--").collect();
        let following = words.windows(2).find(|pair| pair[0] == "--color").map(|pair| pair[1]);
        let color = words.iter().find_map(|word| word.strip_prefix("--color=")).or(following);
        let color = color.and_then(|name| Color::from_str(name, false).ok()).unwrap_or_default();
        Self { json: words.contains(&"--json"), color, ..Self::default() }
    }

    /// Standard error, with colours where they are wanted.
    pub(crate) fn stderr(self) -> AutoStream<std::io::Stderr> {
        let choice = match self.color {
            Color::Auto => AutoStream::choice(&std::io::stderr()),
            Color::Always => ColorChoice::Always,
            Color::Never => ColorChoice::Never,
        };
        AutoStream::new(std::io::stderr(), choice)
    }

    /// Says what `answer`, that of the command called `name`, comes to. A failure to say it is one of the command.
    pub(crate) fn say(self, name: &str, mut answer: Answer) -> u8 {
        if !self.json {
            if let Err(failure) = write_out(&answer.text.shown(terminal_width())) {
                answer.failure = answer.failure.or(Some(failure));
            }
            if let Some(failure) = &answer.failure {
                // With stderr gone there is nobody left to tell.
                let _ = writeln!(self.stderr(), "{failure}");
            }
            return answer.exit_code();
        }
        let text = format!("{:#}\n", answer.json(name));
        match write_out(&text) {
            Ok(()) => answer.exit_code(),
            Err(failure) => {
                let _ = writeln!(self.stderr(), "{failure}");
                2
            }
        }
    }
}

/// Columns of the terminal that stdout is; `None` if it is none.
fn terminal_width() -> Option<usize> {
    terminal_size::terminal_size_of(std::io::stdout()).map(|(width, _)| usize::from(width.0))
}

/// Columns of text for stdout.
pub(super) fn width() -> usize {
    terminal_width().unwrap_or(sindyna_report::text::WIDTH)
}

/// Writes `text` to stdout as it is; a reader that has gone away (`| head`) is not an error.
fn write_out(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::from(anyhow::Error::new(e).context("cannot write to stdout"))
                .hint("results go to stdout: check that its destination has room"))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn form_and_colour_are_known_before_the_command_line_is_understood() {
        let of = |line: &str| {
            let words: Vec<String> = line.split(' ').map(String::from).collect();
            let Console { json, color, .. } = Console::guessed(&words);
            (json, color)
        };
        assert_eq!(of("train --polcy --json"), (true, Color::Auto));
        assert_eq!(of("--color never tasks x"), (false, Color::Never));
        assert_eq!(of("tasks --color=always -- --json"), (false, Color::Always));
        assert_eq!(of("tasks --color=blue"), (false, Color::Auto));
    }
}
