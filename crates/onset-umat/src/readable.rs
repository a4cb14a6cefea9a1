//! Foreign text made safe for a terminal.

/// Removes escape sequences, and all control characters except line feed and tab.
///
/// ```
/// assert_eq!(onset_umat::readable("\u{1b}[2J\u{1b}[31mred\n"), "red\n");
/// ```
pub fn readable(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    let mut rest = text.chars().peekable();
    while let Some(letter) = rest.next() {
        match letter {
            '\u{1b}' => {
                // Characters from 0x20 to 0x2f only specify the kind of sequence.
                let kind = rest.find(|letter| !(' '..='/').contains(letter));
                skip(kind, &mut rest);
            }
            // The same introducers as single characters.
            '\u{9b}' => skip(Some('['), &mut rest),
            '\u{90}' | '\u{98}' | '\u{9d}' | '\u{9e}' | '\u{9f}' => skip(Some(']'), &mut rest),
            '\n' | '\t' => kept.push(letter),
            // Characters that change the writing direction could disguise a text.
            '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {}
            other if other.is_control() => {}
            other => kept.push(other),
        }
    }
    kept
}

/// Largest number of characters in a message, and the number kept at its end, which contains the hint.
const MAX_CHARACTERS: usize = 2000;
const END_CHARACTERS: usize = 500;

/// Message made safe for a terminal and a log by [`readable`], shortened in the middle if it exceeds 2,000 characters.
///
/// ```
/// let long = onset_umat::message(&"1".repeat(100_000));
/// assert!(long.chars().count() <= 2000 && long.contains(" [...] "));
/// ```
pub fn message(text: &str) -> String {
    const GAP: &str = " [...] ";
    let kept = readable(text);
    let count = kept.chars().count();
    if count <= MAX_CHARACTERS {
        return kept;
    }
    let begin = kept
        .chars()
        .take(MAX_CHARACTERS - END_CHARACTERS - GAP.len());
    let end = kept.chars().skip(count - END_CHARACTERS);
    begin.chain(GAP.chars()).chain(end).collect()
}

/// Skips the remainder of a sequence of the given kind.
fn skip(kind: Option<char>, rest: &mut std::iter::Peekable<std::str::Chars<'_>>) {
    match kind {
        // A control sequence ends with a character from @ to ~.
        Some('[') => {
            while rest
                .next_if(|letter| (' '..='?').contains(letter))
                .is_some()
            {}
        }
        // A string, such as a window title, ends with a bell or a string terminator.
        Some(']' | 'P' | 'X' | '^' | '_') => {
            while let Some(letter) = rest.next() {
                match letter {
                    '\u{7}' | '\u{9c}' => return,
                    '\u{1b}' if rest.peek() == Some(&'\\') => break,
                    _ => {}
                }
            }
        }
        _ => return,
    }
    rest.next();
}

#[cfg(test)]
mod tests {
    use super::readable;

    #[test]
    fn no_control_sequences_for_terminals_remain() {
        for (text, expected) in [
            ("plain\n\ttext ü", "plain\n\ttext ü"),
            ("\u{1b}[2J\u{1b}[1;31mred\u{1b}[0m!", "red!"),
            ("\u{1b}]0;title\u{7}a\u{1b}]52;c;Y2F0\u{1b}\\b", "ab"),
            ("a\u{9b}31mb\u{9d}0;x\u{9c}c", "abc"),
            ("\u{1b}(Ba\u{1b}cb\u{1b}Pq\u{1b}\\c", "abc"),
            ("over\rwritten\u{8}\u{8}\u{0}\u{7f}", "overwritten"),
            ("cut \u{1b}", "cut "),
            ("cut \u{1b}[12", "cut "),
            ("cut \u{1b}]0;never ended", "cut "),
            ("a\u{202e}b", "ab"),
        ] {
            assert_eq!(readable(text), expected, "{text:?}");
        }
    }

    #[test]
    fn no_control_character_survives_in_any_text() {
        let letters: Vec<char> = "\u{1b}[]\\m;0(\u{7}\u{9b}\u{9c}ab\n".chars().collect();
        for case in 0..letters.len().pow(4) {
            let text: String = (0..4)
                .map(|n| letters[case / letters.len().pow(n) % letters.len()])
                .collect();
            let shown = readable(&text);
            assert!(
                shown.chars().all(|c| c == '\n' || !c.is_control()),
                "{text:?}"
            );
        }
    }
}
