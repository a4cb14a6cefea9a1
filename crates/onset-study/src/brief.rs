//! Short form of an answer: at most [`LINES`] lines of at most [`WIDTH`] characters, notes included.
//!
//! Lines are divided between words; a word longer than a line exceeds the width. A note is printed with its first sentence, which therefore gives the
//! limit of the answer; its other sentences are explanations. The command line prints the short form by default. The full text of an answer is its
//! `Display`.

use crate::settings::DECK_NOTES;
use std::fmt::Display;

/// Largest number of lines, without the settings.
pub const LINES: usize = 12;
/// Largest number of lines of the notes.
const NOTE_LINES: usize = 4;
/// Number of lines of a table that notes do not displace: the head, and three rows.
const TABLE_LINES: usize = 4;
/// Largest number of characters in a line.
pub const WIDTH: usize = 100;
/// Width of the names of rows.
const NAME: usize = 12;

/// An answer with a short form.
pub trait Brief: Display {
    /// Returns the short form of the answer.
    fn brief(&self) -> Short;
}

/// Parts of a short answer. If they exceed its lines, the least important parts are omitted.
#[derive(Clone, Debug, Default)]
pub struct Short {
    sentence: String,
    table: Vec<String>,
    table_lines: usize,
    rows: Vec<Row>,
    notes: Vec<String>,
    settings: Vec<(&'static str, String)>,
}

/// A line with a name at its beginning.
#[derive(Clone, Debug)]
struct Row {
    name: &'static str,
    text: String,
    /// Priority of the row; rows of the largest rank are omitted first.
    rank: u8,
}

impl Short {
    /// A short answer that begins with a sentence.
    pub(crate) fn new(sentence: impl Into<String>) -> Self {
        Self {
            sentence: sentence.into(),
            table_lines: TABLE_LINES,
            ..Self::default()
        }
    }

    /// Adds a row; rows of the largest rank are omitted first.
    pub(crate) fn row(mut self, rank: u8, name: &'static str, text: impl Into<String>) -> Self {
        let text = text.into();
        self.rows.push(Row { name, text, rank });
        self
    }

    /// Adds a table: its head, then its lines, the most important ones first.
    pub(crate) fn table(mut self, lines: impl IntoIterator<Item = String>) -> Self {
        self.table.extend(lines);
        self
    }

    /// Sets the number of lines of the table that notes do not displace.
    pub(crate) fn table_lines(mut self, lines: usize) -> Self {
        self.table_lines = lines;
        self
    }

    /// Adds notes, the most important ones first.
    pub(crate) fn notes(mut self, notes: &[String]) -> Self {
        self.notes.extend_from_slice(notes);
        self
    }

    /// Adds a line that `--settings` shows.
    pub(crate) fn settings(mut self, name: &'static str, text: impl Into<String>) -> Self {
        self.settings.push((name, text.into()));
        self
    }

    /// Text of the answer, followed by the settings if `has_settings`.
    pub fn text(&self, has_settings: bool) -> String {
        let mut lines = wrapped(&self.sentence, 0);
        lines.push(String::new());
        // The last line names the options for longer answers.
        let mut left = LINES.saturating_sub(lines.len() + 1);
        let rows: Vec<Vec<String>> = self.rows.iter().map(Row::lines).collect();
        let kept = |rank: u8| {
            let own = self.rows.iter().zip(&rows);
            let own = own.filter(|(row, _)| row.rank == rank);
            own.map(|(_, lines)| lines.len()).sum::<usize>()
        };
        let room = left.saturating_sub(kept(0) + self.table.len().min(self.table_lines));
        let notes = self.shown_notes(room.clamp(1, NOTE_LINES));
        left = left.saturating_sub(notes.len());
        let table = self.cut_table(left.saturating_sub(kept(0)));
        left = left.saturating_sub(table.len());
        let mut is_shown = vec![false; rows.len()];
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by_key(|n| self.rows[*n].rank);
        for n in order {
            if rows[n].len() <= left {
                left -= rows[n].len();
                is_shown[n] = true;
            }
        }
        lines.extend(table);
        // The first shown row of a name has the name.
        let mut name = "";
        for (row, is_shown) in self.rows.iter().zip(is_shown) {
            if !row.name.is_empty() {
                name = row.name;
            }
            if is_shown {
                lines.extend(named(std::mem::take(&mut name), &row.text));
            }
        }
        lines.extend(notes);
        lines.push(
            named(
                "more",
                "--all: all numbers and notes; --settings: settings and defaults; --json: all digits",
            )
            .concat(),
        );
        if has_settings {
            lines.push(String::new());
            for (name, text) in self.settings.iter().filter(|(_, text)| !text.is_empty()) {
                lines.extend(named(name, text));
            }
            lines.extend(self.commands().map(|note| format!("note: {note}")));
        }
        lines.join("\n")
    }

    /// Notes with a command that is longer than a line. They are printed on one line with the settings, so that the command can be copied.
    fn commands(&self) -> impl Iterator<Item = &String> {
        let notes = self.notes.iter();
        notes.filter(|note| first_sentence(note).contains("--set ") && note_lines(note).len() > 1)
    }

    /// First sentences of the notes that fit into a number of lines, and the number of omitted notes. Notes on the law of a deck are not omitted.
    fn shown_notes(&self, room: usize) -> Vec<String> {
        let is_of_deck = |note: &&String| DECK_NOTES.iter().any(|own| note.starts_with(own));
        let of_deck = self.notes.iter().filter(is_of_deck);
        let mut lines: Vec<String> = of_deck.flat_map(|note| note_lines(note)).collect();
        // One further note is shown if it has one line.
        let room = room.max(lines.len() + 1);
        let commands: Vec<&String> = self.commands().collect();
        let is_other = |note: &&String| !commands.contains(note) && !is_of_deck(note);
        let notes = self.notes.iter().filter(is_other);
        let notes: Vec<Vec<String>> = notes.map(|note| note_lines(note)).collect();
        for (n, own) in notes.iter().enumerate() {
            let left = notes.len() - n;
            if lines.len() + own.len() + usize::from(left > 1) > room {
                lines.push(format!("note: {left} more: --all"));
                break;
            }
            lines.extend_from_slice(own);
        }
        lines
    }

    /// The lines of the table that fit into a number of lines.
    fn cut_table(&self, room: usize) -> Vec<String> {
        if self.table.len() <= room {
            return self.table.clone();
        }
        let Some(shown) = room.checked_sub(1) else {
            return Vec::new();
        };
        let mut lines = self.table[..shown].to_vec();
        lines.push(format!("... and {} more", self.table.len() - shown));
        lines
    }
}

impl Row {
    fn lines(&self) -> Vec<String> {
        named(self.name, &self.text)
    }
}

/// Lines of the first sentence of a note.
fn note_lines(note: &str) -> Vec<String> {
    wrapped(&format!("note: {}", first_sentence(note)), "note: ".len())
}

/// First sentence of a text, without its period. The next sentence begins with a capital letter, or with a command.
fn first_sentence(text: &str) -> &str {
    let mut ends = text.match_indices(". ").map(|(at, _)| at);
    let begins = |rest: &str| rest.starts_with(|own: char| own.is_uppercase() || own == '`');
    ends.find(|at| begins(&text[at + 2..]))
        .map_or(text, |at| &text[..at])
}

/// A text with its name, wrapped.
fn named(name: &str, text: &str) -> Vec<String> {
    wrapped(&format!("{name:<NAME$}{text}"), NAME)
}

/// A text cut between words to a number of characters; a longer first word is kept.
pub(crate) fn cut(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let mut short = String::new();
    for word in text.split_whitespace() {
        let gap = usize::from(!short.is_empty());
        // Two characters mark the cut.
        if gap == 1 && short.chars().count() + gap + word.chars().count() + 2 > width {
            break;
        }
        short.push_str(&" "[..gap]);
        short.push_str(word);
    }
    short.trim_end_matches([',', ';', ':']).to_owned() + " …"
}

/// Lines of at most [`WIDTH`] characters, indented after the first, divided between words.
pub(crate) fn wrapped(text: &str, indent: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    // The spaces of the name are kept: only the text behind them is divided.
    let (name, text) = text.split_at(text.char_indices().nth(indent).map_or(0, |(at, _)| at));
    line.push_str(name);
    let mut is_empty = true;
    for word in text.split_whitespace() {
        let width = line.chars().count() + usize::from(!is_empty) + word.chars().count();
        if width > WIDTH && !is_empty {
            lines.push(std::mem::replace(&mut line, " ".repeat(indent)));
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
        is_empty = false;
    }
    lines.push(line);
    lines
}

#[cfg(test)]
mod tests {
    use super::{LINES, Short, WIDTH, cut, first_sentence, wrapped};

    #[test]
    fn a_short_answer_never_exceeds_its_lines_and_its_width() {
        let long = "word ".repeat(200);
        let answer = Short::new("A sentence of several words. ".repeat(8))
            .row(0, "verdict", "stable")
            .row(3, "stress", long.clone())
            .table((0..40).map(|n| format!("line {n}")))
            .notes(&["short".to_owned(), long, "another".to_owned()])
            .settings("material", "by default");
        let text = answer.text(false);
        assert!(text.lines().count() <= LINES, "{text}");
        assert!(
            text.lines().all(|line| line.chars().count() <= WIDTH),
            "{text}"
        );
        assert!(text.contains("verdict     stable"), "{text}");
        assert!(text.contains("note: short\nnote: 2 more: --all"), "{text}");
        assert!(!text.contains("by default"), "{text}");
        assert!(answer.text(true).contains("material    by default"));
    }

    #[test]
    fn notes_are_printed_with_their_first_sentence_and_displace_the_end_of_the_table() {
        let long = format!("run --set {}", "k=v ".repeat(40));
        let answer = Short::new("One.")
            .table((0..20).map(|n| format!("line {n}")))
            .row(0, "limits", "in tension")
            .row(1, "evidence", "searched")
            .notes(&[
                "bonds use one modulus. The forces are linear.".to_owned(),
                long.clone(),
                "word ".repeat(30),
                "a third".to_owned(),
            ]);
        let text = answer.text(false);
        assert_eq!(text.lines().count(), LINES, "{text}");
        for fact in [
            "line 2\n",
            "limits      in tension\n",
            "one modulus\nnote: word word",
            "note: a third\n",
        ] {
            assert!(text.contains(fact), "{fact}: {text}");
        }
        for omitted in ["The forces", "run --set", "line 5", "evidence"] {
            assert!(!text.contains(omitted), "{omitted}: {text}");
        }
        // A command can be copied from the settings.
        assert!(answer.text(true).contains(long.trim()), "{text}");
    }

    #[test]
    fn a_sentence_ends_at_a_period_before_a_capital_letter() {
        for (text, first) in [
            ("s11 = 0.5. The term", "s11 = 0.5"),
            ("read it. `onset modes` shows it", "read it"),
            ("equation (5). of the paper", "equation (5). of the paper"),
        ] {
            assert_eq!(first_sentence(text), first);
        }
    }

    #[test]
    fn nothing_is_cut_within_a_word() {
        let path = "x".repeat(300);
        assert_eq!(wrapped(&format!("a {path} b"), 0), ["a", &path, "b"]);
        assert_eq!(cut("penalty 0.5, cubic spline", 15), "penalty 0.5 …");
        assert_eq!(cut("penalty", 7), "penalty");
    }

    #[test]
    fn rows_of_the_largest_rank_are_omitted_first_and_the_order_is_kept() {
        let mut answer = Short::new("One.");
        for rank in [9, 1, 2, 3, 4, 5, 6, 7, 8, 10] {
            answer = answer.row(rank, "row", format!("of rank {rank}"));
        }
        let text = answer.text(false);
        let ranks: Vec<&str> = text
            .lines()
            .filter(|line| line.starts_with("row"))
            .collect();
        let expected =
            [9, 1, 2, 3, 4, 5, 6, 7, 8].map(|rank| format!("row         of rank {rank}"));
        assert_eq!(ranks, expected);
    }

    #[test]
    fn lines_are_divided_between_words_and_indented() {
        let lines = wrapped(&"abcd ".repeat(30), 0);
        assert_eq!(lines.len(), 2);
        assert!(lines.iter().all(|line| line.ends_with("abcd")));
        let lines = wrapped(&format!("name  {}", "abcd ".repeat(30)), 6);
        assert!(lines[0].starts_with("name  abcd") && lines[1].starts_with("      abcd"));
    }
}
