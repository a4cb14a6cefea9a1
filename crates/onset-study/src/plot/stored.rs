//! Stored map, read for a picture with a limited number of cells.

use super::{PlotError, Unfinished};
use crate::caption;
use crate::domain::Class;
use crate::map::{self, stored_layout};
use crate::settings::{Quantity, Study, Trust, Units};
use crate::store::{Column, Kind, LIBRARY, ResultStore, StoreError, ZarrStore, ravel};
use onset::verdict::Verdict;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Maximum number of cells along each edge of a picture; finer maps are thinned to every n-th state.
const CELLS: usize = 1024;

/// Fields of words that can be shown instead of the verdict.
const PROOFS: [&str; 2] = [map::CERTAINTY, map::CERTAINTY_MATERIAL];

/// A store with its study.
pub(super) struct StoredMap {
    store: ZarrStore,
    pub(super) study: Study,
    pub(super) path: PathBuf,
}

/// Section through a map; a map with two axes is its only section.
pub(super) struct Slice {
    /// Study of the section.
    pub(super) study: Study,
    /// Index of the state along the third axis.
    index: Option<usize>,
    /// Value on the third axis, as text.
    pub(super) title: Option<String>,
}

/// Numbers of cells of a picture along its two edges, and the values of the cells.
pub(super) type Picture<T> = ((usize, usize), Vec<T>);

impl StoredMap {
    pub(super) fn open(path: &Path, trust: &Trust) -> Result<Self, PlotError> {
        let store = ZarrStore::open(path).map_err(|error| match error {
            // The hints of these errors concern writing a map, not reading one.
            StoreError::NotAStore { path } | StoreError::Foreign { path } => {
                PlotError::NotAMap { path }
            }
            other => other.into(),
        })?;
        let text = store
            .attributes()
            .get("study")
            .and_then(serde_json::Value::as_str)
            .unwrap_or_default();
        let name = format!("{}: attribute study", path.display());
        let study = Study::parse(&name, text).map_err(|source| PlotError::Study {
            path: path.to_owned(),
            source,
        })?;
        // Stores of an earlier format contain renamed keys, which are not the fault of the user.
        drop(crate::settings::notes_on_settings());
        let mut study = study.allowing(trust);
        if study.settings.material.permitted().is_ok() {
            study
                .settings
                .material
                .fingerprint_is(store.attributes().get(LIBRARY));
        }
        // The layout is checked first, because it determines how much memory the fields need.
        store.check(&stored_layout(&study, store.attributes()))?;
        Ok(Self {
            store,
            study,
            path: path.to_owned(),
        })
    }

    /// Returns true if states that are not stored can be evaluated: no library is needed, or it may be loaded.
    pub(super) fn may_be_evaluated(&self) -> bool {
        self.study.settings.material.permitted().is_ok()
    }

    /// Title of the study, or the name of the folder if the study has no title.
    pub(super) fn title(&self) -> String {
        if self.study.title.is_empty() {
            let name = self.path.file_stem().unwrap_or(self.path.as_os_str());
            name.to_string_lossy().into_owned()
        } else {
            self.study.title.clone()
        }
    }

    /// Settings in effect at all states, as a caption.
    pub(super) fn settings(&self) -> String {
        caption::settings(&self.study.effective())
    }

    fn units(&self) -> Units {
        self.study.settings.units()
    }

    pub(super) fn holds(&self, field: &str) -> bool {
        self.store.fields().any(|stored| stored == field)
    }

    /// Returns the number of tiles not yet computed; `None` if the map is complete.
    pub(super) fn unfinished(&self) -> Result<Option<Unfinished>, PlotError> {
        let tiles = self.store.tiling().tiles();
        let unfinished = Unfinished {
            store: self.path.clone(),
            tiles_left: tiles - self.store.done()?,
            tiles,
        };
        Ok((unfinished.tiles_left > 0).then_some(unfinished))
    }

    /// Sections of the map: the map itself, or at most `most` evenly chosen values of its third axis.
    pub(super) fn slices(&self, most: usize) -> Vec<Slice> {
        let Some(third) = self.study.axes.get(2).copied() else {
            return vec![Slice {
                study: self.study.clone(),
                index: None,
                title: None,
            }];
        };
        let count = third.count.min(most);
        let slice = |n: usize| {
            let index = (2 * n + 1) * third.count / (2 * count);
            let value = third.coordinate(index);
            let mut study = self.study.clone();
            study.axes.truncate(2);
            // A setting that the axis varies can also be fixed.
            let assignment = format!("{}={value:?}", third.quantity.key_name());
            let study = study.override_with(&[assignment]).unwrap_or(study);
            let name = third.title();
            // `unit` may be the name of a dimension, such as stress.
            let unit = match (third.unit(), self.units().are_si()) {
                (unit @ ("rad" | "deg"), _) => format!(" {unit}"),
                (unit, true) if unit != "1" => format!(" {}", self.units().unit(unit)),
                _ => String::new(),
            };
            Slice {
                study,
                index: Some(index),
                title: Some(format!("{name} = {}{unit}", rounded(value))),
            }
        };
        (0..count).map(slice).collect()
    }

    /// Verdicts of a section; `None` for cells not yet computed.
    pub(super) fn classes(&self, slice: &Slice) -> Result<Picture<Option<Class>>, PlotError> {
        let (cells, verdicts) = self.numbers(slice, map::VERDICT)?;
        let (_, stabilities) = self.numbers(slice, "stability")?;
        let class = |(verdict, stability): (&f64, &f64)| {
            if verdict.is_nan() || *verdict < 0.0 {
                return None;
            }
            Some(match Verdict::ALL.get(*verdict as usize) {
                Some(Verdict::Numerical) if *stability == 1.0 => Class::Flutter,
                Some(verdict) => Class::Verdict(*verdict),
                None => Class::Undefined,
            })
        };
        Ok((
            cells,
            verdicts.iter().zip(&stabilities).map(class).collect(),
        ))
    }

    /// Flag meanings of a field of proofs, if the store has it.
    pub(super) fn words(&self, name: &str) -> Option<Vec<&'static str>> {
        if !PROOFS.contains(&name) || !self.holds(name) {
            return None;
        }
        let field = map::fields(&self.study.map)
            .into_iter()
            .find(|field| field.name == name)?;
        match field.kind {
            Kind::Flags(meanings) => Some(meanings),
            Kind::Numbers(_) => None,
        }
    }

    /// Label of a field of numbers, with its unit.
    pub(super) fn label(&self, name: &str) -> Result<String, PlotError> {
        let fields = map::fields(&self.study.map);
        let is_shown =
            |kind: &Kind, is_vector: bool| matches!(kind, Kind::Numbers(_)) && !is_vector;
        let stored: Vec<&str> = self.store.fields().collect();
        let field = fields
            .iter()
            .find(|field| field.name == name && is_shown(&field.kind, field.is_vector))
            .filter(|_| stored.contains(&name));
        match field.map(|field| &field.kind) {
            Some(Kind::Numbers(unit)) => Ok(caption::label(self.units(), &title(name), unit)),
            _ => Err(PlotError::NotShown {
                field: name.to_owned(),
                known: fields
                    .iter()
                    .filter(|field| {
                        is_shown(&field.kind, field.is_vector) || PROOFS.contains(&field.name)
                    })
                    .map(|field| field.name.to_owned())
                    .chain([super::VERDICT.to_owned()])
                    .collect(),
            }),
        }
    }

    /// Values of a field in a section; NaN for cells not yet computed.
    pub(super) fn numbers(&self, slice: &Slice, field: &str) -> Result<Picture<f64>, PlotError> {
        let [first, second] = slice.study.plane();
        let (columns, rows) = (first.count.min(CELLS), second.count.min(CELLS));
        // State in the middle of a cell of the picture.
        let state =
            |cell: usize, cells: usize, states: usize| (2 * cell + 1) * states / (2 * cells);
        let mut values = vec![f64::NAN; columns * rows];
        let (shape, tile) = (&self.store.tiling().shape, &self.store.tiling().tile);
        let axes = shape.len();
        // Tiles that contain a state of the picture, along one dimension. Dimensions are ordered from slowest to fastest, so the second axis is the
        // last but one.
        let along = |dimension: usize| -> BTreeSet<usize> {
            let cells = |cells: usize| {
                (0..cells)
                    .map(|cell| state(cell, cells, shape[dimension]) / tile[dimension])
                    .collect()
            };
            match (axes - 1 - dimension, slice.index) {
                (0, _) => cells(columns),
                (1, _) => cells(rows),
                (_, index) => BTreeSet::from([index.unwrap_or(0) / tile[dimension]]),
            }
        };
        let mut places = vec![Vec::new()];
        for dimension in 0..axes {
            let along = along(dimension);
            let longer = |start: &Vec<usize>| -> Vec<Vec<usize>> {
                let next = along.iter();
                next.map(|tile| start.iter().chain([tile]).copied().collect())
                    .collect()
            };
            places = places.iter().flat_map(longer).collect();
        }
        let grid = self.store.tiling().grid();
        for tile in places.iter().map(|place| ravel(place, &grid)) {
            let place = self.store.tiling().at(tile);
            let (origin, extent) = (&place.origin, &place.extent);
            let holds = |dimension: usize, state: usize| {
                (origin[dimension]..origin[dimension] + extent[dimension]).contains(&state)
            };
            let shown = |dimension: usize, cells: usize, states: usize| -> Vec<(usize, usize)> {
                let cells = (0..cells).map(|cell| (cell, state(cell, cells, states)));
                let inside = cells.filter(|(_, state)| holds(dimension, *state));
                inside
                    .map(|(cell, state)| (cell, state - origin[dimension]))
                    .collect()
            };
            let across = shown(axes - 1, columns, first.count);
            let along = shown(axes - 2, rows, second.count);
            let Some(column) = self.store.read(field, tile)? else {
                continue;
            };
            let layer = slice.index.map_or(0, |index| index - origin[0]);
            for (row, j) in &along {
                for (column_of_picture, i) in &across {
                    let index = (layer * extent[axes - 2] + j) * extent[axes - 1] + i;
                    values[row * columns + column_of_picture] = match &column {
                        Column::Flags(flags) => f64::from(flags[index]),
                        Column::Numbers(numbers) => numbers[index],
                    };
                }
            }
        }
        Ok(((columns, rows), values))
    }

    /// Returns the reason why two maps cannot be overlaid, or `None` if they can be overlaid.
    pub(super) fn differs_from(&self, other: &Self) -> Option<&'static str> {
        let quantities = |study: &Study| -> Vec<Quantity> {
            study.axes.iter().map(|axis| axis.quantity).collect()
        };
        let material = |study: &Study| {
            let material = &study.settings.material;
            (material.model, material.entries())
        };
        if self.study.axes.len() != 2 || other.study.axes.len() != 2 {
            Some("only maps with two axes can be overlaid")
        } else if quantities(&self.study) != quantities(&other.study) {
            Some("they have different axes")
        } else if material(&self.study) != material(&other.study) {
            Some("they have different materials")
        } else if self.study.state != other.study.state {
            Some("their fixed quantities differ")
        } else {
            None
        }
    }
}

/// Name of a field for the color bar.
fn title(field: &str) -> String {
    match field {
        "acoustic_minimum" => "smallest acoustic eigenvalue".to_owned(),
        "scaled_minimum" => "min Re ω² / (c² |k|²)".to_owned(),
        "lowest_omega_squared" => "min Re ω²".to_owned(),
        other => other.replace('_', " "),
    }
}

/// A number with four significant digits, without trailing zeros.
fn rounded(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = 3 - value.abs().log10().floor() as i32;
    if !(-2..=9).contains(&digits) {
        return format!("{value:.3e}");
    }
    let text = format!("{value:.*}", digits.max(0) as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn values_have_four_significant_digits() {
        assert_eq!(rounded(0.261_799_387_8), "0.2618");
        assert_eq!(rounded(1.5), "1.5");
        assert_eq!(rounded(12345.6), "12346");
        assert_eq!(rounded(0.0), "0");
        assert_eq!(rounded(-2.0), "-2");
    }
}
