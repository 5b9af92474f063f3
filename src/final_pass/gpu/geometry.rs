//! The meshes of a scene on the device: positions and corners, one mesh after the other.
//!
//! Positions are relative to the middle of their mesh: what a matrix makes of them is off by a share of the mesh's size and its distance
//! from the eye, and not of its distance from some origin. Where the device's buffers hold less than the scene, there are several.

use bytemuck::cast_slice;
use glam::DVec3;

use super::GpuError;
use super::device::Device;
use super::pipelines::Pipelines;
use crate::scene::{Aabb, Mesh, Scene};

/// All meshes.
#[derive(Debug)]
pub struct Geometry {
    /// Bound to draw what is in each of several pairs of buffers.
    chunks: Vec<wgpu::BindGroup>,
    places: Vec<MeshPlace>,
}

/// Where a mesh is.
#[derive(Clone, Copy, Debug)]
pub struct MeshPlace {
    /// Which pair of buffers.
    pub chunk: usize,
    /// The first corner of its first triangle.
    pub first_corner: u32,
    /// What its positions are relative to, local coordinates.
    pub middle: DVec3,
}

/// What goes into a pair of buffers.
#[derive(Default)]
struct Chunk {
    positions: Vec<[f32; 3]>,
    corners: Vec<u32>,
}

impl Geometry {
    /// Uploads a scene's meshes.
    pub fn upload(
        scene: &Scene,
        device: &Device,
        pipelines: &Pipelines,
    ) -> Result<Geometry, GpuError> {
        let most = device.largest_buffer;
        let mut chunks = Vec::new();
        let mut chunk = Chunk::default();
        let mut places = Vec::with_capacity(scene.meshes().len());
        for mesh in scene.meshes() {
            let [positions, triangles] = [mesh.positions.len(), mesh.triangles.len()];
            if most < bytes(positions.max(triangles)) {
                return Err(GpuError::MeshTooLarge {
                    mesh: mesh.name.clone(),
                    bytes: bytes(positions.max(triangles)),
                    device: device.name().to_owned(),
                    most,
                });
            }
            let is_full = most < bytes(chunk.positions.len() + positions)
                || most < bytes(chunk.corners.len() / 3 + triangles);
            if is_full {
                chunks.push(std::mem::take(&mut chunk).upload(device, pipelines));
            }
            places.push(chunk.add(mesh, chunks.len()));
        }
        chunks.push(chunk.upload(device, pipelines));
        Ok(Geometry { chunks, places })
    }

    /// Where a mesh is.
    pub fn place(&self, mesh: usize) -> MeshPlace {
        self.places[mesh]
    }

    /// Bound to draw what is in a pair of buffers.
    pub fn chunk(&self, chunk: usize) -> &wgpu::BindGroup {
        &self.chunks[chunk]
    }
}

/// What positions or triangles take: three words each.
fn bytes(count: usize) -> u64 {
    12 * count as u64
}

impl Chunk {
    fn add(&mut self, mesh: &Mesh, chunk: usize) -> MeshPlace {
        let point = |p: &[f32; 3]| DVec3::from(p.map(f64::from));
        let middle = match Aabb::around(mesh.positions.iter().map(point)) {
            bounds if bounds.is_valid() => bounds.center(),
            _ => DVec3::ZERO,
        };
        let place = MeshPlace {
            chunk,
            first_corner: self.corners.len() as u32,
            middle,
        };
        let first = self.positions.len() as u32;
        let corners = mesh.triangles.iter().flatten();
        self.corners.extend(corners.map(|corner| first + corner));
        let positions = mesh.positions.iter();
        let relative = positions.map(|p| (point(p) - middle).as_vec3().to_array());
        self.positions.extend(relative);
        place
    }

    fn upload(self, device: &Device, pipelines: &Pipelines) -> wgpu::BindGroup {
        let storage = |bytes: &[u8]| device.buffer(bytes, wgpu::BufferUsages::STORAGE);
        let positions = storage(cast_slice(&self.positions));
        let corners = storage(cast_slice(&self.corners));
        device.bind(
            &pipelines.geometry_layout,
            &[positions.as_entire_binding(), corners.as_entire_binding()],
        )
    }
}
