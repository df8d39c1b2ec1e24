//! Reads the XML of an SDF, Gazebo's format, to a [`Description`].
//!
//! ```text
//! XML ─ model, joint, inertial, include ─▶ World ─ frames ─▶ poses, and the link of each frame ─ build ─▶ Description
//! ```
//!
//! A pose may be relative to any frame of its model, also to one that comes later in the text, so
//! all elements are read before any pose is known.

mod build;
mod collision;
mod files;
mod frames;
mod ground;
mod include;
mod inertial;
mod joint;
mod model;
mod reader;
mod solids;
mod visual;
mod world;

use roxmltree::Node;

use crate::description::{Description, ReadOptions};
use crate::diagnostics::{Code, Report, Severity};
use crate::read::xml::document;
use crate::read::xml::element::{Elements, attribute};
use crate::read::xml::unread::Unread;
use files::Files;
use reader::Reader;
use world::{Overrides, WORLD, World};

/// Returns the description; `None` with errors in the report.
pub fn describe(text: &str, options: &ReadOptions, report: &mut Report<'_>) -> Option<Description> {
    let text = document::with_prefixes_in_names(text);
    let document = document::parse(&text, 0, "sdf", report)?;
    let root = document.root_element();
    let at = root.range().start;
    if root.tag_name().name() != "sdf" {
        let message = format!("the root element is `<{}>`", root.tag_name().name());
        let help = "an SDF is one element `<sdf version=\"...\">`";
        report.error(Code::NotSdf, at, None, message, help);
        return None;
    }
    let version = version(root, 0, report)?;
    let mut world = World::new(at);
    let xml = Elements { root, start: 0, report };
    let folder = options.folder.clone();
    let mut files = Files { first: folder.clone(), folder, open: Vec::new(), count: 0 };
    let mut reader = Reader {
        xml,
        world: &mut world,
        files: &mut files,
        options,
        version,
        unread: Unread::default(),
    };
    reader.root(root);
    let unread = reader.unread;
    unread.warn(report);
    build::describe(world, at, options, report)
}

/// Returns the version of an SDF, times 100; `None` with an error in the report.
fn version(root: Node, start: usize, report: &mut Report<'_>) -> Option<u32> {
    let at = start + root.range().start;
    let text = attribute(root, "version");
    let number = text.and_then(|text| {
        let (major, minor) = text.text.trim().split_once('.')?;
        Some((major.parse::<u32>().ok()?, minor.parse::<u32>().ok()?))
    });
    match number {
        Some((1, minor @ 2..100)) => {
            if minor > LAST_VERSION {
                let message =
                    format!("version 1.{minor} is newer than 1.{LAST_VERSION}, which is read");
                let help = "compare the robot with other software: new elements may be missing";
                report.add(Severity::Warning, Code::SdfVersion, at, None, message, help);
            }
            Some(100 + minor)
        }
        _ => {
            let message = match text {
                Some(text) => format!("the version `{}` is not read", text.text),
                None => "the attribute `version` of `<sdf>` is missing".into(),
            };
            let help =
                format!("write `<sdf version=\"1.{LAST_VERSION}\">`; 1.2 and later are read");
            report.error(
                Code::SdfVersion,
                text.map_or(at, |text| start + text.at),
                None,
                message,
                help,
            );
            None
        }
    }
}

/// The last minor version that is known.
const LAST_VERSION: u32 = 12;

impl<'a> Reader<'a, '_, '_, '_> {
    /// Reads the models of a file, in a world or alone.
    fn root(&mut self, root: Node<'a, '_>) {
        self.warn_of_unknown(root, &["world", "model", "actor", "light"], None);
        let worlds: Vec<_> = self.xml.named(root, "world").collect();
        if let Some(second) = worlds.get(1) {
            let message = "a second `<world>`";
            let help = "keep the world that has the robot";
            self.xml.report.error(Code::SdfModel, second.range().start, None, message, help);
        }
        if let Some(world) = worlds.first() {
            self.world(*world);
        }
        let models: Vec<_> = self.xml.named(root, "model").collect();
        for model in models {
            self.model(model, WORLD, 0, Overrides::default());
        }
    }
}
