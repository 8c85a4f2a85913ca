//! Typed data in buffers: all component types, normalised integers, strides and sparse replacements.

use super::schema::{Accessor, BufferView};
use super::source::Source;
use catoptric_core::error::SceneError;
use std::borrow::Cow;

/// The most elements of an accessor whose data is not all in a buffer.
const MAX_SPARSE_ELEMENTS: u64 = 1 << 24;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// The elements of an accessor, ready to be read one by one.
pub(super) struct Elements<'s> {
    data: Cow<'s, [u8]>,
    stride: usize,
    pub(super) count: usize,
    /// Numbers an element.
    pub(super) width: usize,
    pub(super) component: Component,
    normalized: bool,
}

impl Elements<'_> {
    fn raw<const N: usize>(&self, element: usize, number: usize) -> [u8; N] {
        let begin = element * self.stride + number * N;
        // An accessor without a view is all zeros.
        self.data.get(begin..begin + N).and_then(|bytes| bytes.try_into().ok()).unwrap_or([0; N])
    }

    /// A number of an element; integers that are marked as normalised are scaled to -1..1.
    pub(super) fn float(&self, element: usize, number: usize) -> f32 {
        let (value, scale) = match self.component {
            Component::I8 => (i8::from_le_bytes(self.raw(element, number)) as f32, 127.0),
            Component::U8 => (u8::from_le_bytes(self.raw(element, number)) as f32, 255.0),
            Component::I16 => (i16::from_le_bytes(self.raw(element, number)) as f32, 32767.0),
            Component::U16 => (u16::from_le_bytes(self.raw(element, number)) as f32, 65535.0),
            Component::U32 => (u32::from_le_bytes(self.raw(element, number)) as f32, u32::MAX as f32),
            Component::F32 => return f32::from_le_bytes(self.raw(element, number)),
        };
        if self.normalized { (value / scale).max(-1.0) } else { value }
    }

    /// The first `N` numbers of an element; those it does not have are zero.
    pub(super) fn floats<const N: usize>(&self, element: usize) -> [f32; N] {
        std::array::from_fn(|number| if number < self.width { self.float(element, number) } else { 0.0 })
    }

    /// A number of an element that must be an unsigned integer.
    pub(super) fn index(&self, element: usize, number: usize) -> u32 {
        match self.component {
            Component::U8 => u8::from_le_bytes(self.raw(element, number)).into(),
            Component::U16 => u16::from_le_bytes(self.raw(element, number)).into(),
            Component::U32 => u32::from_le_bytes(self.raw(element, number)),
            _ => self.float(element, number) as u32,
        }
    }

    /// Integers as fractions of their range, whatever the accessor's flag.
    pub(super) fn normalized(mut self) -> Self {
        self.normalized = true;
        self
    }
}

/// Numbers an element of a type.
fn width(kind: &str) -> usize {
    match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" | "MAT2" => 4,
        "MAT3" => 9,
        _ => 16,
    }
}

/// Bytes from one element to the next.
fn stride(view: &BufferView, element_size: u64) -> u64 {
    view.byte_stride.filter(|stride| *stride > 0).unwrap_or(element_size)
}

/// The end of an accessor's data in its view; returns `None` on overflow.
fn data_end(accessor: &Accessor, stride: u64, element_size: u64) -> Option<u64> {
    let last = accessor.count.saturating_sub(1).checked_mul(stride)?;
    last.checked_add(accessor.byte_offset)?.checked_add(element_size)
}

/// Returns true if the data of an accessor of a known type ends after its view.
pub(super) fn is_too_long(accessor: &Accessor, view: &BufferView) -> bool {
    let Some(component) = Component::from_code(accessor.component_type) else { return false };
    let size = (width(&accessor.kind) * component.size()) as u64;
    data_end(accessor, stride(view, size), size).is_none_or(|end| end > view.byte_length)
}

impl Source<'_> {
    /// The elements of an accessor. `kinds` are the types that are allowed here.
    pub(super) fn elements(
        &self,
        index: usize,
        kinds: &[&str],
        field: &dyn Fn() -> String,
    ) -> Result<Elements<'_>, SceneError> {
        let accessor = self.entry(&self.document.accessors, index, field, "accessors")?;
        let owner = || format!("accessors[{index}]");
        if !kinds.contains(&accessor.kind.as_str()) {
            let problem = format!("accessors[{index}] has type `{}`; allowed are {}", accessor.kind, kinds.join(", "));
            return Err(self.invalid(field(), problem));
        }
        let width = width(&accessor.kind);
        let component = Component::from_code(accessor.component_type).ok_or_else(|| {
            let problem = format!("{}; allowed are 5120 to 5123, 5125 and 5126", accessor.component_type);
            self.invalid(format!("{}.componentType", owner()), problem)
        })?;
        if accessor.count == 0 {
            return Err(self.invalid(format!("{}.count", owner()), "0; at least 1 is needed"));
        }
        let size = width * component.size();
        let mut elements = match accessor.buffer_view {
            Some(view) => self.dense(accessor, view, (size, width, component), &owner)?,
            None => {
                if accessor.count > MAX_SPARSE_ELEMENTS {
                    let problem = format!("{} elements without data; at most {MAX_SPARSE_ELEMENTS}", accessor.count);
                    return Err(self.invalid(format!("{}.count", owner()), problem));
                }
                let count = accessor.count as usize;
                let normalized = accessor.normalized;
                Elements { data: Cow::Borrowed(&[]), stride: size, count, width, component, normalized }
            }
        };
        if accessor.sparse.is_some() {
            self.replace_sparse(accessor, size, &mut elements, &owner)?;
        }
        Ok(elements)
    }

    fn dense(
        &self,
        accessor: &Accessor,
        view: usize,
        (size, width, component): (usize, usize, Component),
        owner: &dyn Fn() -> String,
    ) -> Result<Elements<'_>, SceneError> {
        let bytes = self.view(view, &|| format!("{}.bufferView", owner()))?;
        let stride = stride(&self.document.buffer_views[view], size as u64);
        let end = data_end(accessor, stride, size as u64);
        let Some(data) = end
            .filter(|end| *end <= bytes.len() as u64)
            .and_then(|_| bytes.get(usize::try_from(accessor.byte_offset).ok()?..))
        else {
            let problem = format!(
                "{} elements of {size} bytes, every {stride} bytes from byte {}, are more than the {} bytes of \
                bufferViews[{view}]",
                accessor.count,
                accessor.byte_offset,
                bytes.len()
            );
            return Err(self.invalid(owner(), problem));
        };
        let (count, stride, normalized) = (accessor.count as usize, stride as usize, accessor.normalized);
        Ok(Elements { data: Cow::Borrowed(data), stride, count, width, component, normalized })
    }

    /// Replaces single elements; afterwards the elements are packed.
    fn replace_sparse<'s>(
        &'s self,
        accessor: &Accessor,
        size: usize,
        elements: &mut Elements<'s>,
        owner: &dyn Fn() -> String,
    ) -> Result<(), SceneError> {
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        let field = |part: &str| format!("{}.sparse.{part}", owner());
        if accessor.count > MAX_SPARSE_ELEMENTS || sparse.count > accessor.count {
            let problem = format!("{} of {} elements; at most {MAX_SPARSE_ELEMENTS}", sparse.count, accessor.count);
            return Err(self.invalid(field("count"), problem));
        }
        let component = Component::from_code(sparse.indices.component_type)
            .filter(|component| matches!(component, Component::U8 | Component::U16 | Component::U32))
            .ok_or_else(|| self.invalid(field("indices.componentType"), "allowed are 5121, 5123 and 5125"))?;
        let part = |name: &str, view: Option<usize>, offset: u64, element_size: usize| {
            let view_field = || field(&format!("{name}.bufferView"));
            let view = view.ok_or_else(|| self.invalid(view_field(), "missing"))?;
            let bytes = self.view(view, &view_field)?;
            let end = offset.checked_add(sparse.count * element_size as u64).filter(|end| *end <= bytes.len() as u64);
            end.and_then(|end| bytes.get(offset as usize..end as usize)).ok_or_else(|| {
                let problem = format!("{} elements are more than the {} bytes of its view", sparse.count, bytes.len());
                self.invalid(field(name), problem)
            })
        };
        let indices = part("indices", sparse.indices.buffer_view, sparse.indices.byte_offset, component.size())?;
        let values = part("values", sparse.values.buffer_view, sparse.values.byte_offset, size)?;
        self.spend(accessor.count * size as u64, owner)?;
        let mut packed = vec![0u8; elements.count * size];
        for (element, target) in packed.chunks_exact_mut(size).enumerate() {
            let begin = element * elements.stride;
            if let Some(bytes) = elements.data.get(begin..begin + size) {
                target.copy_from_slice(bytes);
            }
        }
        let count = sparse.count as usize;
        let indices = Elements {
            data: Cow::Borrowed(indices),
            stride: component.size(),
            count,
            width: 1,
            component,
            normalized: false,
        };
        for (element, value) in (0..count).zip(values.chunks_exact(size)) {
            let index = indices.index(element, 0) as usize;
            let target = packed.chunks_exact_mut(size).nth(index).ok_or_else(|| {
                self.invalid(field("indices"), format!("index {index} is beyond the {} elements", elements.count))
            })?;
            target.copy_from_slice(value);
        }
        elements.data = Cow::Owned(packed);
        elements.stride = size;
        Ok(())
    }
}
