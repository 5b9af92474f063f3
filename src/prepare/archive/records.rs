//! The small records, field by field, and the elements of the large lists.
//!
//! Records are read into their own types: there are few of them, and a field may be anything until it is looked at.
//! Elements are used where they lie, so each is plain numbers of one size, and any bits are one.

use bytemuck::Pod;

use super::super::clusters::ClusterOutline;

/// Appends bytes.
pub(super) fn put<const N: usize>(out: &mut Vec<u8>, bytes: [u8; N]) {
    out.extend_from_slice(&bytes);
}

/// The fields of a record, one after the other; zeros where it ends too early.
pub(super) struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    pub(super) fn of(record: &'a [u8]) -> Fields<'a> {
        Fields(record)
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        let Some((field, rest)) = self.0.split_first_chunk() else {
            return [0; N];
        };
        self.0 = rest;
        *field
    }

    pub(super) fn u8(&mut self) -> u8 {
        self.take::<1>()[0]
    }

    pub(super) fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    pub(super) fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    pub(super) fn f32(&mut self) -> f32 {
        f32::from_le_bytes(self.take())
    }

    pub(super) fn f64(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }
}

/// A record of a fixed size. The `Err` says which field is none.
pub(super) trait Record: Sized {
    const BYTES: usize;
    fn put(&self, out: &mut Vec<u8>);
    fn read(fields: &mut Fields<'_>) -> Result<Self, &'static str>;
}

/// How much of each section is a mesh's.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshSizes {
    /// Bytes.
    pub name: u64,
    pub positions: u64,
    pub triangles: u64,
    pub surfaces: u64,
    pub clusters: u64,
    /// Padding included.
    pub cluster_vertices: u64,
    pub cluster_quads: u64,
}

impl Record for MeshSizes {
    const BYTES: usize = 64;

    fn put(&self, out: &mut Vec<u8>) {
        let sizes = [
            self.name,
            self.positions,
            self.triangles,
            self.surfaces,
            self.clusters,
            self.cluster_vertices,
            self.cluster_quads,
            0,
        ];
        sizes.iter().for_each(|size| put(out, size.to_le_bytes()));
    }

    fn read(fields: &mut Fields<'_>) -> Result<Self, &'static str> {
        let sizes = MeshSizes {
            name: fields.u64(),
            positions: fields.u64(),
            triangles: fields.u64(),
            surfaces: fields.u64(),
            clusters: fields.u64(),
            cluster_vertices: fields.u64(),
            cluster_quads: fields.u64(),
        };
        (fields.u64() == 0)
            .then_some(sizes)
            .ok_or("its last field is not zero")
    }
}

/// A surface, with how many triangles it has.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceRecord {
    pub triangles: u64,
    pub alpha: u32,
    pub double_sided: u32,
    pub color: [f32; 4],
}

impl Record for SurfaceRecord {
    const BYTES: usize = 32;

    fn put(&self, out: &mut Vec<u8>) {
        put(out, self.triangles.to_le_bytes());
        put(out, self.alpha.to_le_bytes());
        put(out, self.double_sided.to_le_bytes());
        self.color.iter().for_each(|c| put(out, c.to_le_bytes()));
    }

    fn read(fields: &mut Fields<'_>) -> Result<Self, &'static str> {
        Ok(SurfaceRecord {
            triangles: fields.u64(),
            alpha: fields.u32(),
            double_sided: fields.u32(),
            color: [fields.f32(), fields.f32(), fields.f32(), fields.f32()],
        })
    }
}

/// An object but for its name.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjectRecord {
    pub mesh: u32,
    /// [`u32::MAX`] for none.
    pub proxy: u32,
    pub never_cull: bool,
    pub never_occlude: bool,
    /// Bytes.
    pub name: u32,
    pub matrix: [f64; 12],
}

impl Record for ObjectRecord {
    const BYTES: usize = 112;

    fn put(&self, out: &mut Vec<u8>) {
        let flags = u32::from(self.never_cull) | u32::from(self.never_occlude) << 1;
        for field in [self.mesh, self.proxy, flags, self.name] {
            put(out, field.to_le_bytes());
        }
        self.matrix.iter().for_each(|m| put(out, m.to_le_bytes()));
    }

    fn read(fields: &mut Fields<'_>) -> Result<Self, &'static str> {
        let (mesh, proxy, flags, name) = (fields.u32(), fields.u32(), fields.u32(), fields.u32());
        if flags > 3 {
            return Err("its flags are unknown");
        }
        Ok(ObjectRecord {
            mesh,
            proxy,
            never_cull: flags & 1 != 0,
            never_occlude: flags & 2 != 0,
            name,
            matrix: std::array::from_fn(|_| fields.f64()),
        })
    }
}

/// The links of a node of the hierarchy.
impl Record for [u32; 2] {
    const BYTES: usize = 8;

    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|link| put(out, link.to_le_bytes()));
    }

    fn read(fields: &mut Fields<'_>) -> Result<Self, &'static str> {
        Ok([fields.u32(), fields.u32()])
    }
}

/// An object's number.
impl Record for u32 {
    const BYTES: usize = 4;

    fn put(&self, out: &mut Vec<u8>) {
        put(out, self.to_le_bytes());
    }

    fn read(fields: &mut Fields<'_>) -> Result<Self, &'static str> {
        Ok(fields.u32())
    }
}

impl Record for ClusterOutline {
    const BYTES: usize = 16;

    fn put(&self, out: &mut Vec<u8>) {
        let flags = u8::from(self.double_sided) | u8::from(self.axis.is_some()) << 1;
        let ClusterOutline {
            vertex_count,
            triangle_count,
            quad_count,
            ..
        } = *self;
        put(out, [vertex_count, triangle_count, quad_count, flags]);
        let axis = self.axis.unwrap_or_default();
        axis.iter().for_each(|c| put(out, c.to_le_bytes()));
    }

    fn read(fields: &mut Fields<'_>) -> Result<Self, &'static str> {
        let [vertex_count, triangle_count, quad_count, flags] =
            [fields.u8(), fields.u8(), fields.u8(), fields.u8()];
        let axis = [fields.f32(), fields.f32(), fields.f32()];
        if flags > 3 {
            return Err("its flags are unknown");
        }
        let has_axis = flags & 2 != 0;
        if !has_axis && axis.map(f32::to_bits) != [0; 3] {
            return Err("it has an axis but no cone");
        }
        Ok(ClusterOutline {
            vertex_count,
            triangle_count,
            quad_count,
            double_sided: flags & 1 != 0,
            axis: has_axis.then_some(axis),
        })
    }
}

/// An element of a list that is used where it lies: in the file's order of bytes, which is this machine's or is turned.
pub(super) trait Element: Pod + Send + Sync {
    /// The other order of bytes, of each number.
    fn turned(self) -> Self;

    /// From the file's order to the machine's or back.
    fn little_endian(self) -> Self {
        if cfg!(target_endian = "little") {
            self
        } else {
            self.turned()
        }
    }
}

impl Element for f32 {
    fn turned(self) -> f32 {
        f32::from_bits(self.to_bits().swap_bytes())
    }
}

impl Element for [f32; 3] {
    fn turned(self) -> Self {
        self.map(f32::turned)
    }
}

impl Element for [u32; 3] {
    fn turned(self) -> Self {
        self.map(u32::swap_bytes)
    }
}

impl Element for [u8; 4] {
    fn turned(self) -> Self {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_element_has_the_bytes_of_its_numbers_the_other_way_round() {
        let bytes = [0x3f, 0xc0, 0, 1];
        let [there, here] = [f32::from_be_bytes(bytes), f32::from_le_bytes(bytes)];
        assert_eq!(
            [here, there, here].turned().map(f32::to_bits),
            [there, here, there].map(f32::to_bits)
        );
        assert_eq!([1u32, 2, 3].turned(), [1 << 24, 2 << 24, 3 << 24]);
        assert_eq!([1u8, 2, 3, 4].turned(), [1, 2, 3, 4]);
    }
}
