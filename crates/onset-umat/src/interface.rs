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
    /// A behavior of finite strain that MFront has compiled with its generic interface: first Piola-Kirchhoff stress and its derivative.
    Mfront,
}

impl Interface {
    const ALL: [Self; 4] = [Self::Umat, Self::Vumat, Self::Law, Self::Mfront];

    /// Names of the symbol in a library, the usual name first.
    pub(crate) fn symbols(self) -> &'static [&'static str] {
        match self {
            Self::Umat => &["umat_", "umat", "UMAT"],
            Self::Vumat => &["vumat_", "vumat", "VUMAT"],
            Self::Law => &["onset_law", "onset_law_"],
            Self::Mfront => &["<behavior>_mfront_ept"],
        }
    }

    /// The routine that a library must contain, with its language.
    pub(crate) fn expected(self) -> &'static str {
        match self {
            Self::Umat => "SUBROUTINE UMAT compiled as Fortran (or umat_ in C)",
            Self::Vumat => "SUBROUTINE VUMAT compiled as Fortran (or vumat_ in C)",
            Self::Mfront => "behaviors compiled with mfront --obuild --interface=generic",
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
