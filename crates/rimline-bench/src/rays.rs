//! Rays against triangles, in `f64`. The callers define what a ray means.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use bvh::ray::Ray;
use glam::DVec3;
use nalgebra::{Point3, Vector3};

/// Triangles in a tree of boxes.
pub struct Tracer<T> {
    triangles: Vec<Triangle<T>>,
    tree: Tree,
}

pub struct Triangle<T> {
    pub corners: [DVec3; 3],
    pub of: T,
}

/// The tree alone. No caller's type is part of it, because generic code is compiled in the caller's crate, and tests are
/// optimised less than this crate (`Cargo.toml`).
struct Tree {
    shapes: Vec<Shape>,
    boxes: Bvh<f64, 3>,
}

struct Shape {
    corners: [DVec3; 3],
    triangle: usize,
    node: usize,
}

impl Bounded<f64, 3> for Shape {
    fn aabb(&self) -> Aabb<f64, 3> {
        let [a, b, c] = self.corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        // A flat box could be missed by a ray that only just meets it.
        let slack = 1e-9 * (1.0 + high.abs().max(low.abs()));
        let point = |p: DVec3| Point3::new(p.x, p.y, p.z);
        Aabb::with_bounds(point(low - slack), point(high + slack))
    }
}

impl BHShape<f64, 3> for Shape {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl Shape {
    fn met(&self, (from, direction): (DVec3, DVec3)) -> Option<(f64, usize)> {
        Some((meeting(self.corners, from, direction)?, self.triangle))
    }
}

impl Tree {
    fn build(corners: Vec<[DVec3; 3]>) -> Self {
        let shape = |(triangle, corners)| Shape { corners, triangle, node: 0 };
        let mut shapes: Vec<_> = corners.into_iter().enumerate().map(shape).collect();
        let boxes = Bvh::build(&mut shapes);
        Self { shapes, boxes }
    }

    fn meetings(&self, ray: (DVec3, DVec3)) -> Vec<(f64, usize)> {
        self.boxes.traverse(&through_boxes(ray), &self.shapes).into_iter().filter_map(|shape| shape.met(ray)).collect()
    }

    fn nearest(&self, ray: (DVec3, DVec3)) -> Option<(f64, usize)> {
        // Without a list of all, which costs more than the meetings.
        let line = through_boxes(ray);
        let meetings = self.boxes.traverse_iterator(&line, &self.shapes).filter_map(|shape| shape.met(ray));
        meetings.filter(|(t, _)| *t > 0.0).min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

fn through_boxes((from, direction): (DVec3, DVec3)) -> Ray<f64, 3> {
    Ray::new(Point3::new(from.x, from.y, from.z), Vector3::new(direction.x, direction.y, direction.z))
}

impl<T> Tracer<T> {
    pub fn build(triangles: impl IntoIterator<Item = ([DVec3; 3], T)>) -> Self {
        let triangles: Vec<_> = triangles.into_iter().map(|(corners, of)| Triangle { corners, of }).collect();
        let tree = Tree::build(triangles.iter().map(|triangle| triangle.corners).collect());
        Self { triangles, tree }
    }

    /// Where the line through `from` along `direction` meets triangles, in multiples of `direction` and in no order.
    /// Meetings behind `from` may be missing.
    pub fn meetings(&self, (from, direction): (DVec3, DVec3)) -> impl Iterator<Item = (f64, &Triangle<T>)> {
        self.tree.meetings((from, direction)).into_iter().map(move |(t, triangle)| (t, &self.triangles[triangle]))
    }

    /// Where a ray first meets a triangle, in multiples of `direction`, and which.
    pub fn nearest(&self, ray: (DVec3, DVec3)) -> Option<(f64, &Triangle<T>)> {
        let (t, triangle) = self.tree.nearest(ray)?;
        Some((t, &self.triangles[triangle]))
    }

    /// Where a ray first meets a triangle, and which.
    pub fn first(&self, (from, direction): (DVec3, DVec3)) -> Option<(DVec3, &Triangle<T>)> {
        let (t, triangle) = self.nearest((from, direction))?;
        Some((from + direction * t, triangle))
    }
}

impl<T> Triangle<T> {
    /// The normal, counter-clockwise outside, is against `direction`.
    pub fn is_front(&self, direction: DVec3) -> bool {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a).dot(direction) < 0.0
    }
}

/// Möller and Trumbore, from both sides.
fn meeting([a, b, c]: [DVec3; 3], from: DVec3, direction: DVec3) -> Option<f64> {
    let (u, v) = (b - a, c - a);
    let p = direction.cross(v);
    let determinant = u.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = from - a;
    let x = s.dot(p) / determinant;
    let q = s.cross(u);
    let y = direction.dot(q) / determinant;
    (x >= 0.0 && y >= 0.0 && x + y <= 1.0).then(|| v.dot(q) / determinant)
}
