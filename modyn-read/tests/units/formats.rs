//! The format of a text.

use modyn_read::Format;

#[test]
fn a_format_is_recognised_by_the_text_then_by_the_name() {
    for (text, file, format) in [
        ("<mujoco/>", "robot.urdf", Format::Mjcf),
        ("<?xml version='1.0'?>\n<!-- <robot> --><mujoco model='m'>", "robot.xml", Format::Mjcf),
        ("<robot name='r'/>", "robot.xml", Format::Urdf),
        ("<robot name='mujoco'/>", "robot.mjcf", Format::Urdf),
        ("", "robot.MJCF", Format::Mjcf),
        ("", "robot.xml", Format::Urdf),
        ("<sdf/>", "-", Format::Sdf),
        ("<robot name='r'/>", "robot.urdf.xacro", Format::Xacro),
        ("<robot name='r'><xacro:m/></robot>", "robot.urdf", Format::Xacro),
        ("<robot xmlns:xacro='x' name='${r}'/>", "robot.urdf", Format::Urdf),
        ("", "robot.xacro", Format::Xacro),
    ] {
        assert_eq!(Format::of(text, file), format, "{text} {file}");
    }
}
