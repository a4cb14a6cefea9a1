//! Presets: the methods of particle codes as sets of keys, one file each.
//!
//! A preset is an additional word of `discretization.method`. Its keys apply unless the user sets them.

mod lammps_peri;
mod lammps_peri_lps;
mod lammps_smd_tlsph;
mod lammps_smd_ulsph;
mod moose_nospd;
mod nairn_fmpm_2;
mod peridigm_correspondence;
mod peridigm_lps;
mod perilab_correspondence;
mod pysph_gtvf;
mod pysph_solid;
mod sphinxsys_tl;
mod sphinxsys_ul;
mod taichi_mpm88;

/// Key whose words the presets are.
pub(crate) const METHOD: &str = "discretization.method";

/// Method of a particle code, with the defaults of the code.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Preset {
    /// Name on the command line.
    pub(crate) name: &'static str,
    /// The code and its method.
    pub(crate) title: &'static str,
    /// Version of the code.
    pub(crate) version: &'static str,
    /// Publication and file of the code.
    pub(crate) source: &'static str,
    /// Word of `discretization.method` for the family of the method.
    pub(crate) method: &'static str,
    /// Keys with their values, which apply unless the user sets them.
    pub(crate) keys: &'static [(&'static str, &'static str)],
    /// Names of the numbers of a deck, and parts of the code that the preset leaves out.
    pub(crate) note: &'static str,
}

/// All presets, in the order in which they are listed.
pub(crate) const PRESETS: &[Preset] = &[
    lammps_smd_tlsph::PRESET,
    lammps_smd_ulsph::PRESET,
    lammps_peri::PRESET,
    lammps_peri_lps::PRESET,
    peridigm_lps::PRESET,
    peridigm_correspondence::PRESET,
    perilab_correspondence::PRESET,
    moose_nospd::PRESET,
    pysph_solid::PRESET,
    pysph_gtvf::PRESET,
    sphinxsys_tl::PRESET,
    sphinxsys_ul::PRESET,
    taichi_mpm88::PRESET,
    nairn_fmpm_2::PRESET,
];

/// Names of all presets, in the order in which they are listed.
pub fn preset_names() -> impl Iterator<Item = &'static str> {
    PRESETS.iter().map(|preset| preset.name)
}

#[cfg(test)]
mod tests {
    use super::{METHOD, PRESETS};
    use crate::answers::Problem;
    use crate::settings::{Key, Settings};
    use crate::verify::CODES;

    #[test]
    fn every_preset_builds_a_method_and_sets_no_unused_key() {
        for preset in PRESETS {
            let settings = Settings::from_assignments(&[format!("{METHOD}={}", preset.name)])
                .unwrap_or_else(|error| panic!("{}: {error}", preset.name));
            for (name, value) in preset.keys {
                let key = Key::named(name).expect("a key");
                // The form of the penalty is not read while its coefficient, which the user sets, is zero.
                let is_form = *name == "discretization.penalty-form";
                assert!(
                    is_form || settings.unmet(key).is_none(),
                    "{}: {name}",
                    preset.name
                );
                let held = settings.value(name).expect("a value").to_string();
                assert_eq!(held.trim_matches('"'), *value, "{}: {name}", preset.name);
            }
            Problem::new(settings).expect("a method");
        }
    }

    #[test]
    fn keys_of_the_user_override_a_preset_in_either_order() {
        let preset = "discretization.method=peridigm-lps";
        let own = "discretization.influence=parabolic";
        for assignments in [[preset, own], [own, preset]] {
            let settings = Settings::from_assignments(&assignments).expect("settings");
            let value = settings.value("discretization.influence").expect("a value");
            assert_eq!(value.to_string(), "\"parabolic\"");
        }
    }

    #[test]
    fn decks_of_a_code_fix_the_keys_of_its_preset() {
        let mut compared = 0;
        for code in CODES {
            let Some(preset) = PRESETS.iter().find(|preset| preset.name == code.name()) else {
                continue;
            };
            for (name, value) in preset.keys {
                let mut fixed = code.dialect().iter();
                let fixed = fixed.find(|own| own.key == *name).expect("a fixed key");
                assert_eq!(fixed.value, *value, "{}: {name}", preset.name);
            }
            compared += 1;
        }
        assert_eq!(compared, 3);
    }
}
