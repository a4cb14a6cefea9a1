//! Names of methods that fit into a column and stay distinct.

use crate::brief::cut;
use crate::settings::Key;

/// Name of the method of a study that is compared with the built-in methods.
pub(crate) const OWN_METHOD: &str = "the study's own method";

/// Smallest length of a shortened part of a name; characters.
const SHORTEST: usize = 3;

/// Short names of methods.
pub(super) struct Labels {
    /// Keys whose values the names list, if the names of the keys are omitted.
    pub(super) keys: Option<String>,
    /// Names in the order of the methods.
    pub(super) names: Vec<String>,
}

impl Labels {
    /// Names without what all of them share, if one of them exceeds the width: variants of a method are named by their values.
    pub(super) fn without_common(names: &[&str], width: usize) -> Self {
        let unchanged = || Self {
            keys: None,
            names: names.iter().map(|name| (*name).to_owned()).collect(),
        };
        if names.iter().all(|name| name.chars().count() <= width) {
            return unchanged();
        }
        let parts: Vec<Vec<&str>> = names.iter().map(|own| own.split(", ").collect()).collect();
        let count = parts.first().map_or(0, Vec::len);
        if names.len() < 2 || parts.iter().any(|own| own.len() != count) {
            return unchanged();
        }
        let mut keys = Vec::new();
        let mut values: Vec<Vec<&str>> = vec![Vec::new(); names.len()];
        for n in 0..count {
            let first = parts[0][n];
            if parts.iter().all(|own| own[n] == first) {
                continue;
            }
            let key_of = |own: &Vec<&str>| own[n].split_once(' ').map(|(key, _)| key.to_owned());
            // Words of names that the user writes are not keys.
            let is_key = |key: &String| {
                let sections = ["discretization", "time"].into_iter();
                let mut full = sections.map(|section| format!("{section}.{key}"));
                key.contains('.') || full.any(|name| Key::named(&name).is_some())
            };
            let key = key_of(&parts[0]).filter(is_key).filter(|key| {
                let mut others = parts.iter();
                others.all(|own| key_of(own).as_ref() == Some(key))
            });
            for (own, values) in parts.iter().zip(&mut values) {
                let value = own[n].split_once(' ').filter(|_| key.is_some());
                values.push(value.map_or(own[n], |(_, value)| value));
            }
            keys.extend(key);
        }
        Self {
            keys: (!keys.is_empty()).then(|| keys.join(", ")),
            names: values.iter().map(|own| own.join(", ")).collect(),
        }
    }

    /// Distinct names of at most `width` characters.
    pub(super) fn fitting(names: &[&str], width: usize) -> Self {
        let mut labels = Self::without_common(names, width);
        let shortened = |names: &[String], short: &dyn Fn(&str) -> String| -> Option<Vec<String>> {
            let names: Vec<String> = names.iter().map(|name| short(name)).collect();
            let is_distinct = |(n, own): (usize, &String)| {
                own.chars().count() <= width && !names[..n].contains(own)
            };
            names.iter().enumerate().all(is_distinct).then_some(names)
        };
        labels.names = shortened(&labels.names, &|name| cut(name, width))
            .or_else(|| shortened(&labels.names, &|name| squeezed(name, width)))
            .unwrap_or_else(|| {
                let names = labels.names.iter().enumerate();
                names
                    .map(|(n, name)| {
                        let number = format!("{} ", n + 1);
                        let room = width.saturating_sub(number.chars().count());
                        number + &start(name, room)
                    })
                    .collect()
            });
        labels
    }
}

/// First characters of a text; an ellipsis marks the cut.
fn start(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let kept = text.chars().take(width.saturating_sub(1));
    kept.chain(['…']).collect()
}

/// Name whose longest parts are shortened until it fits, so that the beginning of each part remains.
fn squeezed(name: &str, width: usize) -> String {
    let parts: Vec<&str> = name.split(", ").collect();
    let mut widths: Vec<usize> = parts.iter().map(|part| part.chars().count()).collect();
    let gaps = 2 * (parts.len() - 1);
    while widths.iter().sum::<usize>() + gaps > width {
        match widths.iter_mut().max() {
            Some(longest) if *longest > SHORTEST => *longest -= 1,
            _ => break,
        }
    }
    let parts = parts.iter().zip(&widths);
    let parts: Vec<String> = parts.map(|(part, width)| start(part, *width)).collect();
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::Labels;

    #[test]
    fn names_of_variants_stay_distinct_in_every_width() {
        let names = [
            "kernel cubic-spline, smoothing-length 1.2",
            "kernel cubic-spline, smoothing-length 1.3",
            "kernel wendland-c2, smoothing-length 1.2",
        ];
        let labels = Labels::fitting(&names, 50);
        assert_eq!(labels.names, names);
        let labels = Labels::fitting(&names, 20);
        assert_eq!(
            labels.names,
            ["cubic-spline, 1.2", "cubic-spline, 1.3", "wendland-c2, 1.2"]
        );
        assert_eq!(labels.keys.as_deref(), Some("kernel, smoothing-length"));
        for width in 6..50 {
            let names = Labels::fitting(&names, width).names;
            assert!(names.iter().all(|own| own.chars().count() <= width));
            assert!(names[0] != names[1] && names[1] != names[2], "{names:?}");
        }
    }

    #[test]
    fn what_all_names_share_is_omitted() {
        let names = [
            "total-lagrangian-sph, penalty 0.1",
            "total-lagrangian-sph, penalty 0.2",
        ];
        let labels = Labels::fitting(&names, 20);
        assert_eq!(labels.names, ["0.1", "0.2"]);
        assert_eq!(labels.keys.as_deref(), Some("penalty"));
    }
}
