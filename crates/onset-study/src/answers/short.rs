//! Short form of the answer for a state.

use super::state::StateAnswer;
use crate::brief::{Brief, Short};
use crate::caption;
use crate::number::{counted, told, told_below, vector};

impl Brief for StateAnswer {
    fn brief(&self) -> Short {
        let (material, d) = (&self.material, &self.discretization);
        let units = self.settings.units();
        let ((law, law_defaults), (method, method_defaults)) =
            (caption::law(&self.settings), self.settings.discretization());
        let wave = format!(
            "{}; k = {}",
            d.mode,
            units.of(vector(&d.wave_vector), "1/m")
        );
        let mut short = Short::new(&self.sentence)
            .row(0, "verdict", self.named_verdict())
            .row(1, "evidence", self.evidence.words())
            .row(2, if d.stable { "softest" } else { "critical" }, wave)
            .row(3, "material", law)
            .row(
                3,
                "",
                format!(
                    "strongly elliptic: {}; smallest acoustic eigenvalue {}",
                    self.ellipticity(),
                    self.eigenvalue(material.minimum_acoustic_eigenvalue, material.rounding)
                ),
            )
            .row(6, "stress", units.of(material.stresses(), "(Pa)"));
        if let Some((name, found)) = self.found_across() {
            short = short.row(
                5,
                name.split_once(' ').map_or(name, |(first, _)| first),
                found,
            );
        }
        short = short.row(2, "method", method);
        let time = |step: f64| units.of(told_below(step), "s");
        let mut steps = Vec::new();
        match &d.discrete_time {
            Some(own) => steps.extend(
                own.largest_time_step
                    .map(|step| format!("below {} (infinite lattice)", time(step))),
            ),
            None if !d.damped_time_steps.is_empty() => {
                steps.extend(
                    d.damped_time_steps
                        .iter()
                        .map(|(integrator, step)| match *step {
                            0.0 => format!("none ({integrator}, with damping)"),
                            step => format!("below {} ({integrator}, with damping)", time(step)),
                        }),
                );
            }
            None => steps.extend(d.critical_time_step.map(|step| match step {
                0.0 => format!("none ({})", d.integrator_words()),
                step => format!(
                    "below {} ({}, infinite lattice)",
                    time(step),
                    d.integrator_words()
                ),
            })),
        }
        steps.extend(
            d.finite_bodies
                .as_ref()
                .map(|body| format!("{} (finite bodies)", time(body.time_step))),
        );
        steps.extend(d.body.as_ref().and_then(|body| {
            let particles = counted(body.particles, "particle");
            let step = match body.time_step? {
                0.0 => "none".to_owned(),
                step => time(step),
            };
            Some(format!("{step} (this body of {particles})"))
        }));
        if !steps.is_empty() {
            short = short.row(2, "time step", steps.join(", "));
        }
        if let Some((step, growth)) = d
            .discrete_time
            .as_ref()
            .and_then(|own| own.time_step.zip(own.growth_rate))
        {
            let text = match growth > 0.0 {
                true => format!(
                    "with the step {} a wave grows at the rate {}",
                    time(step),
                    units.of(told(growth), "1/s")
                ),
                false => format!("with the step {} no wave grows", time(step)),
            };
            short = short.row(1, "", text);
        }
        if let Some(implicit) = d.implicit.as_ref().filter(|_| steps.is_empty()) {
            for (n, (_, text)) in implicit.lines(units).into_iter().enumerate() {
                short = short.row(2, if n == 0 { "implicit" } else { "" }, text);
            }
        }
        if let Some(run_step) = &self.run_step {
            short = short.row(0, "run", run_step.words(units));
        }
        if let Some(relaxation) = &self.relaxation {
            short = short.row(1, "relaxation", relaxation.words(units));
        }
        if let Some(unloading) = &self.unloading {
            short = short.row(1, "unloading", unloading.words(units));
        }
        for (name, text) in self.certificate.iter().flat_map(|proof| proof.short()) {
            short = short.row(1, name, text);
        }
        for (n, command) in self.next.iter().enumerate() {
            let (rank, name) = if n == 0 { (1, "next") } else { (4, "") };
            short = short.row(rank, name, in_short(command));
        }
        short
            .notes(&self.notes)
            .settings("material", law_defaults)
            .settings("method", method_defaults)
    }
}

/// A command without its settings.
fn in_short(command: &str) -> String {
    match command.split_once(" --set ") {
        Some((begin, _)) => format!("{begin} ... (with these settings; in full: --all)"),
        None => command.to_owned(),
    }
}
