//! Assignments as the sections of a study.

/// Writes assignments as `[material]` and `[discretization]` of a study.
pub(crate) fn sections(assignments: &[String]) -> String {
    let section = |name: &str| {
        let lines = assignments.iter().filter_map(|assignment| {
            let (key, value) = assignment.split_once('=')?;
            let key = key.trim().strip_prefix(name)?.strip_prefix('.')?;
            Some(format!("{key} = {}\n", written(value.trim())))
        });
        let lines: String = lines.collect();
        (!lines.is_empty()).then(|| format!("[{name}]\n{lines}"))
    };
    let sections = ["material", "discretization"]
        .into_iter()
        .filter_map(section);
    sections.collect::<Vec<_>>().join("\n")
}

/// Value as TOML: a number or a switch, or a text in quotes.
fn written(value: &str) -> String {
    let is_plain = || toml::from_str::<toml::Table>(&format!("value = {value}")).is_ok();
    match value.parse::<f64>() {
        _ if matches!(value, "true" | "false") => value.to_owned(),
        Ok(_) if is_plain() => value.to_owned(),
        Ok(number) => format!("{number:?}"),
        Err(_) => toml::Value::from(value).to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::sections;

    #[test]
    fn assignments_become_sections_with_their_values() {
        let set = [
            "discretization.support=2.",
            "material.young=1e9",
            "discretization.kernel=(1-q)^3",
        ];
        let text = sections(&set.map(str::to_owned));
        assert_eq!(
            text,
            "[material]\nyoung = 1e9\n\n[discretization]\nsupport = 2.0\nkernel = \"(1-q)^3\"\n"
        );
    }
}
