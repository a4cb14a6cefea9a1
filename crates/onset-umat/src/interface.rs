//! Interfaces of the routines in a library.

/// Interface of the routine of a library.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interface {
    /// `SUBROUTINE UMAT` of Abaqus/Standard: Cauchy stress and `DDSDDE`.
    #[default]
    Umat,
    /// `SUBROUTINE VUMAT` of Abaqus/Explicit in double precision: stress in corotational axes; the tangent is computed from differences of it.
    Vumat,
    /// The function `onset_law` of `onset_law.h`: first Piola-Kirchhoff stress, and its derivative where the function sets it.
    Law,
}

impl Interface {
    const ALL: [Self; 3] = [Self::Umat, Self::Vumat, Self::Law];

    /// Names of the symbol in a library, the usual name first.
    pub(crate) fn symbols(self) -> &'static [&'static str] {
        match self {
            Self::Umat => &["umat_", "umat", "UMAT"],
            Self::Vumat => &["vumat_", "vumat", "VUMAT"],
            Self::Law => &["onset_law", "onset_law_"],
        }
    }

    /// The routine that a library must contain, with its language.
    pub(crate) fn expected(self) -> &'static str {
        match self {
            Self::Umat => "SUBROUTINE UMAT compiled as Fortran (or umat_ in C)",
            Self::Vumat => "SUBROUTINE VUMAT compiled as Fortran (or vumat_ in C)",
            Self::Law => "the function that `onset law-header` declares, extern \"C\" in C++",
        }
    }

    pub(crate) fn code(self) -> u64 {
        self as u64
    }

    pub(crate) fn of_code(code: u64) -> Option<Self> {
        Self::ALL.into_iter().find(|own| own.code() == code)
    }
}
