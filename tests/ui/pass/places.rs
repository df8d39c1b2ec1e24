//! In modules, in functions, through other macros, beside the source and elsewhere.
#![deny(warnings)]

mod inner {
    pub mod deeper {
        modyn::modyn!(pub(in crate::inner) Narrow = "../good.urdf");
        modyn::modyn!(pub(super) Wide = "../good.urdf");
    }
    pub fn joints() -> usize {
        deeper::Narrow::NV + deeper::Wide::NV
    }
}

macro_rules! robot {
    ($(#[$attribute:meta])* $visibility:vis $name:ident, $path:literal, $x:expr) => {
        $(#[$attribute])*
        mod robot {
            modyn::modyn!($visibility $name = $path, gravity = [$x, -1.0, 0.0]);
        }
    };
}
robot!(#[allow(missing_docs)] pub Wrapped, "../good.urdf", -2.5);

fn main() {
    modyn::modyn!(Local = r"../good.urdf");
    assert_eq!((inner::joints(), Local::NV), (4, 2));
    assert_eq!(robot::Wrapped::GRAVITY, [-2.5, -1.0, 0.0]);
}
