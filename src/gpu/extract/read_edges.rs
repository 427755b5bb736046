//! Reads the silhouette of a light back, for tools.

use super::errors::ExtractorError;
use super::extraction::Extraction;
use super::polygon_buffers::faces_of_records;
use crate::Mesh;
use crate::cpu::extract::edges::{FaceMasks, record_masks};
use crate::gpu::common::download::{Copied, Download, wait};
use crate::mesh::Silhouette;

/// The bit of a list's entry that has the winding.
const WINDING: u32 = 1 << 31;

/// The source of the edges, when their number is known.
enum Source {
    /// So many entries of the light's list.
    List,
    /// The facing masks of all faces, because the list overflowed or there is none.
    Facing,
}

impl Extraction {
    /// Reads the silhouette of light number `light` of `mesh`, once the encoder was submitted. It waits for the device;
    /// [`Self::read_edges_async`] does not. Only the light's entries in its list are read. If the list overflowed, or there
    /// are no lists, the facing masks of its batch of lights are read instead.
    ///
    /// `mesh` is the mesh of the extractor, or a clone of it. `queue` must be the queue of the extractor's device.
    ///
    /// # Errors
    /// [`ExtractorError`] if the mesh is another one, the light was not extracted, a later encode overwrites the results, or
    /// the device does not hand them back.
    pub fn read_edges(&self, queue: &wgpu::Queue, mesh: &Mesh, light: usize) -> Result<Silhouette, ExtractorError> {
        let device = self.shared.device();
        let count = count_of(wait(device, self.download_count(queue, mesh, light)?)?)?;
        let Some((source, download)) = self.download_edges(queue, light, count)? else {
            return Ok(Silhouette::default());
        };
        self.silhouette(mesh, light, &source, wait(device, download)?)
    }

    /// Reads the silhouette as [`Self::read_edges`] does, without waiting, and submits nothing before the first poll.
    /// [`read_back_async`](crate::gpu::read_back_async) says who polls. An encode of the same extractor before the
    /// future is ready makes it fail with [`ExtractorError::Stale`].
    ///
    /// # Errors
    /// The errors of [`Self::read_edges`].
    pub async fn read_edges_async(
        &self,
        queue: &wgpu::Queue,
        mesh: &Mesh,
        light: usize,
    ) -> Result<Silhouette, ExtractorError> {
        let count = count_of(self.download_count(queue, mesh, light)?.await?)?;
        let Some((source, download)) = self.download_edges(queue, light, count)? else {
            return Ok(Silhouette::default());
        };
        self.silhouette(mesh, light, &source, download.await?)
    }

    /// Submits the copy of the number of silhouette edges.
    fn download_count(&self, queue: &wgpu::Queue, mesh: &Mesh, light: usize) -> Result<Download, ExtractorError> {
        self.check_current()?;
        let lights = self.lights().len();
        if light >= lights {
            return Err(ExtractorError::NoSuchLight { light, lights });
        }
        if mesh.id != self.shared.mesh {
            return Err(ExtractorError::OtherMesh);
        }
        let at = 4 * light as u64;
        Ok(Download::new(self.shared.device(), queue, &self.shared.buffers.counts, at..at + 4)?)
    }

    /// Submits the copy of the list of edges, or of the masks if it overflowed. `None` if there are none.
    fn download_edges(
        &self,
        queue: &wgpu::Queue,
        light: usize,
        count: u32,
    ) -> Result<Option<(Source, Download)>, ExtractorError> {
        // The extractor may have encoded again since the count was read.
        self.check_current()?;
        let (batch, capacity) = (light / 32, self.shared.shape.capacity);
        let (device, buffers) = (self.shared.device(), &self.shared.buffers);
        let (source, buffer, range) = match (buffers.lists.get(batch), buffers.facing.get(batch)) {
            (Some(_), _) if count == 0 => return Ok(None),
            (Some(list), _) if count <= capacity => {
                let at = 4 * u64::from(capacity) * (light % 32) as u64;
                (Source::List, list, at..at + 4 * u64::from(count))
            }
            (_, Some(facing)) => (Source::Facing, facing, 0..4 * self.shared.shape.face_words as u64),
            (_, None) => return Err(ExtractorError::NoFacing { light }),
        };
        Ok(Some((source, Download::new(device, queue, buffer, range)?)))
    }

    fn silhouette(
        &self,
        mesh: &Mesh,
        light: usize,
        source: &Source,
        copied: Copied,
    ) -> Result<Silhouette, ExtractorError> {
        let words = words_of(copied)?;
        let Source::Facing = source else {
            return Ok(Silhouette::new(mesh, words.iter().map(|word| (word & !WINDING, word & WINDING != 0))));
        };
        let (facing, twisted) = words.split_at(self.shared.shape.faces.min(words.len()));
        let bit = 1 << (light % 32);
        let of_polygons = faces_of_records(mesh);
        let faces = of_polygons.as_deref().unwrap_or(mesh.edges().packed_faces());
        let found = (0..).zip(faces).filter_map(|(record, &faces)| {
            let masks = record_masks(faces, FaceMasks { facing, twisted }, bit);
            (masks.silhouette & bit != 0).then_some((record, masks.winding & bit != 0))
        });
        Ok(Silhouette::new(mesh, found))
    }
}

fn words_of(copied: Copied) -> Result<Vec<u32>, ExtractorError> {
    let mut words = Vec::new();
    copied.hand_to(&mut |bytes| words.extend(bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned::<u32>)))?;
    Ok(words)
}

fn count_of(copied: Copied) -> Result<u32, ExtractorError> {
    Ok(words_of(copied)?.first().copied().unwrap_or(0))
}
