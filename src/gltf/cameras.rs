//! The cameras of an asset, placed by their nodes.

use glam::{DAffine3, DVec3};

use super::asset::Asset;
use super::camera::SceneCamera;
use super::document::{Part, unit_vector};
use super::error::GltfError;

impl Asset {
    /// The cameras of the chosen scene at a time in seconds, in the order of its nodes. Those of hidden nodes are there, too,
    /// since nothing of a camera is seen. One that is damaged or not finite does not refuse the others.
    ///
    /// # Errors
    /// [`GltfError`] for animations or a time that [`Asset::pose`] refuses.
    pub fn each_camera(
        &self,
        animations: impl IntoIterator<Item = usize>,
        time_s: f32,
    ) -> Result<Vec<Result<SceneCamera, GltfError>>, GltfError> {
        let world = self.state(animations, time_s)?.world;
        let cameras = self.nodes_with(&self.graph.all, |node| node.camera.as_ref());
        Ok(cameras.map(|(n, camera)| self.camera(n, camera, &world[n], time_s)).collect())
    }

    /// The name of each of [`Asset::each_camera`], or that of its node.
    pub fn camera_names(&self) -> Vec<Option<&str>> {
        self.names(&self.document.cameras, self.nodes_with(&self.graph.all, |node| node.camera.as_ref()))
    }

    /// The camera of node `n`, whose world matrix is given.
    fn camera(&self, n: usize, camera: &Part<usize>, world: &DAffine3, time_s: f32) -> Result<SceneCamera, GltfError> {
        let damaged = |source| GltfError::DamagedCamera { node: n, source };
        self.graph.check(&self.document, n).map_err(|fault| damaged(Box::new(fault)))?;
        let (name, &projection) = self.part_of(n, &self.document.cameras, camera).map_err(damaged)?;
        let forward = -unit_vector(world.matrix3.z_axis);
        let up = unit_vector(world.matrix3.y_axis).reject_from_normalized(forward).normalize();
        let [eye, forward, up] = [world.translation, forward, up].map(DVec3::as_vec3);
        if !(eye.is_finite() && forward.is_finite() && up.is_finite()) {
            return Err(GltfError::NotFinite { json_path: format!("nodes[{n}]"), time_s });
        }
        Ok(SceneCamera { name, eye: eye.into(), forward: forward.into(), up: up.into(), projection })
    }
}
