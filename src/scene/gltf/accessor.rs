//! Accessors: typed elements in a buffer view, perhaps with some of them replaced (glTF §3.6.2).
//!
//! **Invariant.** An [`Elements`] has been measured against its view before the first element is read, in u64 with
//! every sum checked; reading then cannot go out of range for any element below `count`. Nothing is copied: an
//! accessor that claims four billion elements costs nothing until someone asks for them.

use ::gltf::json::accessor::{ComponentType, Type};
use ::gltf::json::validation::Checked;

use super::{Result, Source, lookup};
use crate::scene::error::Fault;

/// The elements of one accessor.
pub(super) struct Elements<'a> {
    /// Which accessor it is.
    pub index: u32,
    /// How many elements it has.
    pub count: usize,
    /// What each component is.
    pub component: ComponentType,
    /// What each element is.
    pub element: Type,
    /// Whether integers stand for fractions of their range.
    pub normalized: bool,
    base: Option<Strided<'a>>,
    replaced: Option<Replaced<'a>>,
}

#[derive(Clone, Copy)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// Elements that replace others; `at` is strictly increasing.
struct Replaced<'a> {
    count: usize,
    at: Strided<'a>,
    at_component: ComponentType,
    values: Strided<'a>,
}

/// `count` elements of `size` bytes in a view from `offset` on, if they are there.
fn strided(bytes: &[u8], offset: u64, stride: u64, size: u64, count: u64) -> Option<Strided<'_>> {
    let stride = if stride == 0 { size } else { stride };
    let length = match count.checked_sub(1) {
        Some(gaps) => gaps.checked_mul(stride)?.checked_add(size)?,
        None => 0,
    };
    let end = offset
        .checked_add(length)
        .filter(|&end| end <= bytes.len() as u64)?;
    (stride >= size).then(|| Strided {
        bytes: &bytes[offset as usize..end as usize],
        stride: stride as usize,
    })
}

impl<'a> Elements<'a> {
    /// Measures an accessor against its views.
    pub(super) fn open(source: &'a Source<'_>, index: u32) -> Result<Elements<'a>> {
        let record = lookup(&source.document.accessors, index, "accessor")?;
        let damaged = |cause: String| Fault::damaged(format_args!("accessor {index}"), cause);
        let within = |fault: Fault| fault.within(format_args!("accessor {index}"));
        let (Checked::Valid(component), Checked::Valid(element)) =
            (&record.component_type, &record.element)
        else {
            return Err(damaged(
                "its componentType or type is none that glTF knows".to_owned(),
            ));
        };
        let (component, element) = (component.0, *element);
        let size = (component.size() * element.multiplicity()) as u64;
        let count = usize::try_from(record.count)
            .map_err(|_| damaged(format!("{} elements", record.count)))?;
        let base = match record.buffer_view {
            Some(view) => {
                let (record_of_view, bytes) = source.buffers.view(view).map_err(within)?;
                let stride = record_of_view.byte_stride;
                let base = strided(bytes, record.byte_offset, stride, size, record.count).ok_or_else(|| {
                    damaged(format!(
                        "{count} elements of {size} bytes, from byte {} on with stride {stride}, do not fit into \
                         buffer view {view}, which has {} bytes",
                        record.byte_offset,
                        bytes.len()
                    ))
                })?;
                Some(base)
            }
            None if record.sparse.is_some() => None,
            None => {
                let compressed = source.document.uses("KHR_draco_mesh_compression");
                let cause = "it has neither a buffer view nor sparse values";
                return Err(if compressed {
                    Fault::unsupported(
                        format_args!("accessor {index}"),
                        cause,
                        "decompress the file (Draco) first",
                    )
                } else {
                    damaged(cause.to_owned())
                });
            }
        };
        let mut elements = Elements {
            index,
            count,
            component,
            element,
            normalized: record.normalized,
            base,
            replaced: None,
        };
        if let Some(sparse) = &record.sparse {
            elements.replaced = Some(elements.open_sparse(source, sparse, size).map_err(within)?);
        }
        Ok(elements)
    }

    fn open_sparse(
        &self,
        source: &'a Source<'_>,
        sparse: &super::document::Sparse,
        size: u64,
    ) -> Result<Replaced<'a>> {
        let place = "sparse";
        let Checked::Valid(at_component) = &sparse.indices.component_type else {
            return Err(Fault::damaged(
                place,
                "its indices have a componentType that glTF does not allow there",
            ));
        };
        let at_component = at_component.0;
        let (_, at_bytes) = source
            .buffers
            .view(sparse.indices.buffer_view)
            .map_err(|f| f.within(place))?;
        let (_, value_bytes) = source
            .buffers
            .view(sparse.values.buffer_view)
            .map_err(|f| f.within(place))?;
        let at = strided(
            at_bytes,
            sparse.indices.byte_offset,
            0,
            at_component.size() as u64,
            sparse.count,
        );
        let values = strided(
            value_bytes,
            sparse.values.byte_offset,
            0,
            size,
            sparse.count,
        );
        let (Some(at), Some(values)) = (at, values) else {
            return Err(Fault::damaged(
                place,
                format!(
                    "{} elements do not fit into their buffer views",
                    sparse.count
                ),
            ));
        };
        // Reserved for the time it takes to check them: many accessors may share one long list.
        source
            .budget
            .reserve(sparse.count.saturating_mul(4), "sparse elements")?;
        let replaced = Replaced {
            count: sparse.count as usize,
            at,
            at_component,
            values,
        };
        let mut lowest = 0;
        for i in 0..replaced.count {
            let element = replaced.position(i);
            if element < lowest || element as usize >= self.count {
                return Err(Fault::damaged(
                    place,
                    format!(
                        "index {i} is {element}, but they must increase and stay below {}",
                        self.count
                    ),
                ));
            }
            lowest = element + 1;
        }
        Ok(replaced)
    }

    fn size(&self) -> usize {
        self.component.size() * self.element.multiplicity()
    }

    /// An element's bytes; `None` stands for zeros.
    fn bytes(&self, i: usize) -> Option<&'a [u8]> {
        if let Some(values) = self
            .replaced
            .as_ref()
            .and_then(|r| r.find(i).map(|k| r.values.element(k, self.size())))
        {
            return Some(values);
        }
        self.base.map(|base| base.element(i, self.size()))
    }

    /// An element's first `N` components, as fractions if they are normalised.
    pub(super) fn floats<const N: usize>(&self, i: usize) -> [f32; N] {
        let Some(bytes) = self.bytes(i) else {
            return [0.0; N];
        };
        let width = self.component.size();
        std::array::from_fn(|c| self.float(&bytes[c * width..(c + 1) * width]))
    }

    fn float(&self, bytes: &[u8]) -> f32 {
        let fraction = |integer: f32, range: f32| {
            if self.normalized {
                (integer / range).max(-1.0)
            } else {
                integer
            }
        };
        match (self.component, bytes) {
            (ComponentType::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            (ComponentType::I8, &[a]) => fraction(f32::from(a as i8), 127.0),
            (ComponentType::U8, &[a]) => fraction(f32::from(a), 255.0),
            (ComponentType::I16, &[a, b]) => {
                fraction(f32::from(i16::from_le_bytes([a, b])), 32767.0)
            }
            (ComponentType::U16, &[a, b]) => {
                fraction(f32::from(u16::from_le_bytes([a, b])), 65535.0)
            }
            _ => unsigned(bytes) as f32,
        }
    }

    /// An element's first `N` components, as the unsigned integers they are.
    pub(super) fn integers<const N: usize>(&self, i: usize) -> [u32; N] {
        let Some(bytes) = self.bytes(i) else {
            return [0; N];
        };
        let width = self.component.size();
        std::array::from_fn(|c| unsigned(&bytes[c * width..(c + 1) * width]))
    }

    /// Complains unless the accessor is of one of these kinds.
    pub(super) fn must_be(
        &self,
        element: Type,
        components: &[ComponentType],
        role: &str,
    ) -> Result<()> {
        if self.element == element && components.contains(&self.component) {
            return Ok(());
        }
        Err(Fault::damaged(
            format_args!("accessor {}", self.index),
            format_args!(
                "{role} cannot be {:?} of {:?}: {element:?} of {components:?} is allowed",
                self.element, self.component
            ),
        ))
    }
}

impl<'a> Strided<'a> {
    fn element(self, i: usize, size: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..i * self.stride + size]
    }
}

impl Replaced<'_> {
    fn position(&self, i: usize) -> u32 {
        unsigned(self.at.element(i, self.at_component.size()))
    }

    /// Which of the replacements is for element `i`.
    fn find(&self, i: usize) -> Option<usize> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            match (self.position(middle) as usize).cmp(&i) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Equal => return Some(middle),
                std::cmp::Ordering::Greater => high = middle,
            }
        }
        None
    }
}

/// Little endian, of one, two or four bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes
        .iter()
        .rev()
        .fold(0, |value, &byte| value << 8 | u32::from(byte))
}
