//! `onset audit`: checks of a material's implementation.

use super::Failure;
use crate::arguments::AuditArguments;
use crate::printing::print;
use onset_study::answers::Strain;
use onset_study::audit::{Audit, states};
use std::process::ExitCode;

/// Audits the material in the settings.
pub fn audit(arguments: &AuditArguments) -> Result<ExitCode, Failure> {
    let material = arguments.problem.law()?;
    let mut deformations = Vec::new();
    for stretches in &arguments.stretch {
        deformations.push(Strain::of_stretches("--stretch", stretches, 2)?.0);
    }
    for components in &arguments.deformation_gradient {
        deformations.push(Strain::of_components("--deformation-gradient", components, 2)?.0);
    }
    if deformations.is_empty() {
        deformations = states(arguments.strain).map_err(Failure::input)?;
    }
    let audit = Audit::of_material(&material, arguments.convention, &deformations)
        .map_err(Failure::input)?;
    let printed = print(&audit, audit.to_string().trim_end(), || audit.csv())?;
    Ok(match arguments.strict && !audit.consistent {
        true => ExitCode::from(1),
        false => printed,
    })
}
