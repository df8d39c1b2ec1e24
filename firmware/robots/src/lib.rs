//! The robots of the images, compiled by modyn. The images' build script runs the same code on
//! the host.
#![no_std]
#![forbid(unsafe_code)]
#![deny(warnings)]

macro_rules! robots {
    ($($module:ident: $($name:ident = $file:literal),*;)*) => {
        $(
            pub mod $module {
                $(
                    pub mod $name {
                        include!(concat!(env!("OUT_DIR"), "/", $file, ".rs"));
                    }
                )*
            }
        )*
    };
}

// The robots are self-contained, except for `ordinary` and `loaded` (with run-time parameters), which depend on
// `modyn-runtime`.
robots! {
    single: arm7 = "arm7_f32", gripper = "gripper_f32", leg = "leg_f32", legs = "legs_f32",
        legs_shared = "legs_shared_f32", ordinary = "ordinary_f32", loaded = "loaded_f32";
    double: arm7 = "arm7_f64", gripper = "gripper_f64", leg = "leg_f64", legs = "legs_f64",
        legs_shared = "legs_shared_f64", ordinary = "ordinary_f64", loaded = "loaded_f64";
}

/// The arm's C header and source.
pub mod c {
    macro_rules! texts {
        ($($name:ident = $scalar:literal),*) => {
            $(
                pub const $name: [(&str, &str); 2] = [
                    ("arm7.h", include_str!(concat!(env!("OUT_DIR"), "/arm7_", $scalar, ".h"))),
                    ("arm7.c", include_str!(concat!(env!("OUT_DIR"), "/arm7_", $scalar, ".c"))),
                ];
            )*
        };
    }
    texts!(SINGLE = "f32", DOUBLE = "f64");
}
