//! A crate with the strictest lints, whose robots have names that the expansion uses.
#![forbid(unsafe_code)]
#![deny(warnings, missing_docs, clippy::pedantic)]

modyn::modyn!("../../../../robots/gripper.urdf");

/// The robots that the build script compiled.
pub mod included {
    modyn::include_model!(gripper);

    /// Names that collide.
    pub mod names {
        modyn::include_model!(robot);
        modyn::include_model!(option);
        modyn::include_model!(t);
        modyn::include_model!(some);
        modyn::include_model!(none);
    }
}

/// The robots that the macro compiled.
pub mod names {
    modyn::modyn!(pub Robot = "../robots/clash.urdf");
    modyn::modyn!(pub Option = "../robots/clash.urdf");
    modyn::modyn!(pub T = "../robots/clash.urdf");
    modyn::modyn!(pub Some = "../robots/clash.urdf");
    modyn::modyn!(pub None = "../robots/clash.urdf");
    modyn::modyn!(pub Ok = "../robots/clash.urdf");
    modyn::modyn!(pub Scalar = "../robots/clash.urdf");
    modyn::modyn!(pub Factorization = "../robots/clash.urdf");
    modyn::modyn!(pub Default = "../robots/clash.urdf");
    modyn::modyn!(pub Copy = "../robots/clash.urdf");
    modyn::modyn!(pub Sized = "../robots/clash.urdf");
    modyn::modyn!(pub Q = "../robots/clash.urdf");
    modyn::modyn!(pub V = "../robots/clash.urdf");
    modyn::modyn!(pub M = "../robots/clash.urdf");
    modyn::modyn!(pub Poses = "../robots/clash.urdf");
    modyn::modyn!(pub Params = "../robots/clash.urdf");
    modyn::modyn!(pub Brge = "../robots/clash.urdf");
    modyn::modyn!(pub FnMut = "../robots/clash.urdf");
    modyn::modyn!(pub Into = "../robots/clash.urdf");
    modyn::modyn!(
        pub Loaded = "../robots/clash.urdf",
        functions = all,
        runtime_gravity = true,
        runtime_inertia = ["Some", "None", "\u{202e}Ok"],
        payload = ["Some", "None", "\u{202e}Ok"],
    );
}

#[cfg(test)]
mod tests {
    use super::names::{OptionJoint, OptionLink, Some, TJoint};

    #[test]
    fn names_are_kept() {
        assert_eq!(Some::NAME, r##"r#"robot"# */ {} // \"##);
        assert_eq!(Some::JOINT_NAMES[1], "T");
        assert_eq!(TJoint::Self_.name(), "Self");
        assert_eq!(
            Some::JOINT_NAMES[3],
            "rtl\u{202e}ltr\u{2066}\u{200f}\u{61c}\u{2028}\u{200b}end"
        );
        assert_eq!(OptionLink::ALL.len(), 5);
        assert_eq!(OptionJoint::ALL.map(OptionJoint::index), [0, 1, 2, 3]);
    }
}
