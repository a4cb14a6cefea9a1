//! Files of answers with a figure: where they are written, and how the figure is drawn.

use crate::commands::Failure;
use clap::Args;
use onset_study::figure::{Figure, Sheet, Size, Theme};
use onset_study::output::Output;
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// Endings of the kinds of figures that are written.
const FIGURE_ENDINGS: [&str; 3] = ["svg", "png", "pdf"];
/// Endings of pictures that are refused.
const OTHER_PICTURE_ENDINGS: [&str; 8] = ["eps", "ps", "jpg", "jpeg", "tif", "tiff", "gif", "webp"];

/// Returns true if a path has the ending of a figure, or of a picture that is refused.
pub fn is_picture(path: &Path) -> bool {
    let ending = path.extension().and_then(OsStr::to_str);
    ending.is_some_and(|own| FIGURE_ENDINGS.contains(&own) || OTHER_PICTURE_ENDINGS.contains(&own))
}

/// Options for size, frame and colors of figures.
#[derive(Debug, Clone, Default, Args)]
pub struct LookArguments {
    /// Width of the picture with a unit, for example 84mm: letters have 8 pt then; or width and height of a panel in pixels (96 per inch), for example
    /// 420,315. With stretches on both axes a panel may be smaller.
    #[arg(long, value_name = "SIZE", help_heading = "Look")]
    pub size: Option<Size>,
    /// Draw neither title nor caption; NAME.txt has them as one paragraph for LaTeX.
    #[arg(long, help_heading = "Look")]
    pub bare: bool,
    /// Colors: light or dark [default: light].
    #[arg(long, value_name = "NAME", value_parser = theme, help_heading = "Look")]
    pub theme: Option<Theme>,
}

/// Options of commands that draw one figure.
#[derive(Debug, Clone, Default, Args)]
pub struct DrawingArguments {
    /// Size, frame and colors.
    #[command(flatten)]
    pub look: LookArguments,
    /// Title of the figure.
    #[arg(long, value_name = "TEXT", help_heading = "Look")]
    pub title: Option<String>,
}

fn theme(name: &str) -> Result<Theme, String> {
    let known = Theme::ALL.into_iter().find(|own| own.name() == name);
    known.ok_or_else(|| "expected light or dark".to_owned())
}

impl LookArguments {
    /// The sheet of figures that keep their titles.
    pub fn sheet(&self) -> Sheet {
        Sheet {
            size: self.size,
            title: None,
            bare: self.bare,
            theme: self.theme.unwrap_or_default(),
        }
    }
}

impl DrawingArguments {
    /// The sheet of the figure.
    pub fn sheet(&self) -> Sheet {
        Sheet {
            title: self.title.clone(),
            ..self.look.sheet()
        }
    }

    /// Refuses options for a figure that is not drawn; the error shows an example of an output path.
    ///
    /// # Errors
    /// [`Failure`] with the first option that has no effect.
    pub fn refuse_idle(&self, place: &str) -> Result<(), Failure> {
        let given = [
            ("--size", self.look.size.is_some()),
            ("--title", self.title.is_some()),
            ("--bare", self.look.bare),
            ("--theme", self.look.theme.is_some()),
        ];
        match given.iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) => Err(Failure::input(format!(
                "{option} has no effect: no figure is drawn\n  hint: give its place, for example --out {place}"
            ))),
            None => Ok(()),
        }
    }

    /// Prepares the files of an answer with one figure: all files in a folder, or only the figure for NAME.svg, NAME.png or NAME.pdf; `None` without
    /// an output path.
    ///
    /// # Errors
    /// [`Failure`] if the place cannot be written, if it has the ending of another format, or if options of a figure are given without a place.
    pub fn output(
        &self,
        out: Option<&Path>,
        figure: &str,
        others: &[&str],
    ) -> Result<Option<Output>, Failure> {
        let Some(out) = out else {
            self.refuse_idle(&format!("{figure}.pdf"))?;
            return Ok(None);
        };
        let sheet = self.sheet();
        let names = |name: &OsStr| {
            Figure::ENDINGS.map(|ending| {
                let mut name = name.to_owned();
                name.push(ending);
                name
            })
        };
        let extension = out.extension().and_then(OsStr::to_str);
        let output = match (extension, out.file_stem()) {
            (Some(own), Some(stem)) if FIGURE_ENDINGS.contains(&own) => {
                let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
                Output::at(folder.unwrap_or(Path::new(".")), &names(stem))?.only(stem)
            }
            (Some(own), _) if OTHER_PICTURE_ENDINGS.contains(&own) => {
                return Err(Failure::input(format!(
                    "cannot draw {}: figures are written as SVG, PNG and PDF\n  hint: give a name that ends in .svg, .png or .pdf",
                    out.display()
                )));
            }
            _ => {
                let mut all = names(figure.as_ref()).to_vec();
                all.extend(others.iter().map(OsString::from));
                Output::at(out, &all)?
            }
        };
        Ok(Some(output.on(sheet)))
    }
}
