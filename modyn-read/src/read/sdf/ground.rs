//! The ground of a world, and the collisions that touch it: planes that do not move are the ground.

use std::path::PathBuf;

use modyn_runtime::ContactSurface;
use modyn_runtime::model::SoftConstraints;
use modyn_runtime::spatial::Pose;

use super::frames::Frames;
use super::world::{Collision, CollisionGeometry, Link, Surface, WORLD, World};
use crate::description::{Base, Description, ReadOptions, contact_plane};
use crate::diagnostics::{Code, Place, Report, Subject};
use crate::read::collision::{self, Collisions, link_indices, moving_links};
use crate::read::visual::Surfaces;

/// A plane that does not move.
struct Plane {
    /// The contact with the plane, without friction.
    contact: ContactSurface<f64>,
    /// The coefficient that replaces the friction of all contacts with the plane.
    friction: Option<f64>,
    surface: Surface,
}

/// The surface of the plane of the options: the collisions decide about contacts with it.
const OPEN: Surface = Surface { friction: [f64::INFINITY; 2], mask: u32::MAX, has_more: false };

/// What touches the ground.
#[derive(Default)]
struct Touching {
    collisions: Collisions,
    /// The places of friction that differs between the tangents of a contact.
    anisotropic: Vec<Place>,
    /// The places of surfaces with more properties than friction.
    unread: Vec<Place>,
}

/// The search for what touches the ground.
pub struct Grounding<'w, 'r, 'f> {
    pub world: &'w World,
    pub frames: &'w Frames,
    /// For each scope, whether it belongs to a model that can move.
    pub inside: &'w [bool],
    pub options: &'w ReadOptions,
    pub surfaces: Surfaces,
    pub report: &'r mut Report<'f>,
}

impl Grounding<'_, '_, '_> {
    /// Returns what steps have by the shapes that touch planes; `None` if there is no plane, or if
    /// contacts of the options replace the shapes.
    pub fn soft_constraints(&mut self, description: &Description) -> Option<SoftConstraints> {
        if !self.options.contacts.is_empty() {
            return None;
        }
        // The description has the base that the options ask for.
        let moves = moving_links(description, Base::Auto);
        let indices = link_indices(description);
        let world = self.world;
        let index = |link: &Link| {
            let frame = &world.frames[link.frame];
            let index = indices.get(&*frame.name.text).copied();
            index.filter(|index| self.inside[frame.scope] && moves[*index])
        };
        let links: Vec<(Option<usize>, &Link)> =
            world.links.iter().map(|link| (index(link), link)).collect();
        let planes = self.planes(&links);
        if planes.is_empty() {
            return None;
        }
        let mut touching = Touching::default();
        for (index, link) in links.iter().filter_map(|(index, link)| Some(((*index)?, *link))) {
            for collision in &link.collisions {
                self.add([index, link.frame], collision, &planes, &mut touching);
            }
        }
        self.report.warn_once(
            Code::NotRead,
            &touching.anisotropic,
            "contacts have in `step` the friction `<mu>` in all directions",
            "write the same number in `<mu>` and `<mu2>`",
        );
        self.report.warn_once(
            Code::NotRead,
            &touching.unread,
            "`<bounce>` and `<torsional>` of a `<surface>` have no effect in `step`",
            "remove them; `StepSettings` has the torsional friction of contacts with a moment",
        );
        Some(touching.collisions.soft_constraints(self.report))
    }

    /// Adds the shape of a collision of a link, by its indices in the description and among the
    /// frames, for each plane that it touches.
    fn add(
        &mut self,
        [link, frame]: [usize; 2],
        collision: &Collision,
        planes: &[Plane],
        touching: &mut Touching,
    ) {
        let is_touched = |plane: &&Plane| plane.surface.mask & collision.surface.mask != 0;
        let touched: Vec<&Plane> = planes.iter().filter(is_touched).collect();
        if touched.is_empty() || touching.collisions.are_too_many() {
            return;
        }
        let Some(shape) = self.shape(frame, collision) else { return };
        let name = &self.world.frames[frame].name.text;
        let place: Place = (Some(collision.at), Some(Subject::Link(name.clone())));
        let mixed = touched.iter().map(|plane| plane.frictions(&collision.surface));
        let frictions: Vec<[f64; 2]> = mixed.collect();
        if frictions.iter().any(|[first, second]| first != second) {
            touching.anisotropic.push(place.clone());
        }
        if collision.surface.has_more {
            touching.unread.push(place);
        }
        let contacts = touched.iter().zip(frictions);
        let surfaces: Vec<ContactSurface<f64>> = contacts
            .map(|(plane, [friction, _])| ContactSurface { friction, ..plane.contact })
            .collect();
        touching.collisions.add(link, name, shape, &surfaces);
    }

    /// Returns the plane of the options, or the planes of links that do not move.
    fn planes(&mut self, links: &[(Option<usize>, &Link)]) -> Vec<Plane> {
        let still = links.iter().filter(|(index, _)| index.is_none());
        let collisions = still.flat_map(|(_, link)| link.collisions.iter().map(|one| (*link, one)));
        let mut planes = Vec::new();
        let mut first = None;
        for (link, collision) in collisions {
            let CollisionGeometry::Plane(normal) = collision.geometry else { continue };
            let Some(on_link) = self.pose(link.frame, collision) else { continue };
            collision.diagnostics.iter().for_each(|one| self.report.push(one.clone()));
            let pose = self.frames.pose(self.world, WORLD, link.frame).compose(&on_link);
            let plane = contact_plane(pose.translation, pose.rotate(normal));
            let contact = ContactSurface { plane, ..ContactSurface::<f64>::GROUND };
            planes.push(Plane { contact, friction: None, surface: collision.surface });
            first = first.or(Some(collision.at));
        }
        let Some(ground) = self.options.ground else { return planes };
        if let Some(at) = first {
            let message = "the option `ground` adds a plane, and the file has one";
            let help = "leave the option out, or remove the plane from the file";
            self.report.error(Code::Option, at, None, message, help);
        }
        vec![Plane { contact: ground.surface(), friction: ground.friction, surface: OPEN }]
    }

    /// Returns the pose of a collision in its link's frame; `None` with an error in the report.
    fn pose(&mut self, link: usize, collision: &Collision) -> Option<Pose<f64>> {
        let Some(name) = &collision.relative_to else { return Some(collision.pose) };
        let scope = self.world.frames[link].scope;
        let Some(frame) = self.world.find(scope, &name.text) else {
            let message = format!("the frame `{}` does not exist here", name.text);
            let help = "name a link, joint or frame of the same model, or `__model__`";
            self.report.error(Code::FrameName, name.at, None, message, help);
            return None;
        };
        Some(self.frames.between(self.world, scope, [link, frame]).compose(&collision.pose))
    }

    /// Returns a collision that touches the ground; `None` if it is empty, or with an error in the
    /// report.
    fn shape(&mut self, link: usize, collision: &Collision) -> Option<collision::Collision> {
        collision.diagnostics.iter().for_each(|one| self.report.push(one.clone()));
        let pose = self.pose(link, collision)?;
        let geometry = match &collision.geometry {
            CollisionGeometry::Empty => return None,
            CollisionGeometry::Plane(_) => Err("it is a `<plane>` that moves".into()),
            CollisionGeometry::Other(why) => Err(why.clone()),
            CollisionGeometry::Solid(solid) => Ok(solid.clone()),
            CollisionGeometry::Mesh(mesh) => {
                let places: Vec<PathBuf> = mesh.place.iter().cloned().collect();
                places.iter().for_each(|place| self.report.depends_on(place.clone()));
                let files = &self.options.files;
                let surface =
                    self.surfaces.surface(files, &mesh.uri, &places, mesh.scale.as_deref());
                surface.map_err(|why: String| format!("its geometry {why}"))
            }
        };
        let name = Some(collision.name.clone()).filter(|name| !name.is_empty());
        Some(collision::Collision { name, at: collision.at, pose, geometry })
    }
}

impl Plane {
    /// Returns the coefficients of friction along the two tangents of a contact of a collision with
    /// this surface: of two coefficients, the smaller one counts, as in Gazebo.
    fn frictions(&self, surface: &Surface) -> [f64; 2] {
        match self.friction {
            Some(friction) => [friction; 2],
            None => [0, 1].map(|k| surface.friction[k].min(self.surface.friction[k])),
        }
    }
}
