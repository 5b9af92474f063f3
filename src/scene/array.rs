//! A list that owns its elements, or shares them with whatever holds them: a file that is mapped into memory.
//!
//! Either way it is read like a slice. What is shared is found once, when the list is made; from then on it is a pointer
//! and a length, as a `Vec` is, and what it lies in is kept as long as the list.

use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

use yoke::Yoke;
use yoke::erased::ErasedArcCart;

/// A list of numbers that is read like a slice: its own, or a part of an archive that is mapped into memory.
///
/// ```
/// use antumbra::scene::Array;
///
/// let mut triangles: Array<[u32; 3]> = vec![[0, 1, 2]].into();
/// triangles.to_mut().push([2, 1, 3]);
/// assert_eq!(triangles.len(), 2);
/// assert_eq!(triangles, [[0, 1, 2], [2, 1, 3]]);
/// ```
pub struct Array<T: 'static>(Held<T>);

enum Held<T: 'static> {
    Own(Vec<T>),
    Shared(Yoke<&'static [T], ErasedArcCart>),
}

impl<T> Array<T> {
    /// A part of `owner`, which lives at least as long; none if `part` finds none.
    pub(crate) fn shared<C: Send + Sync + 'static>(
        owner: Arc<C>,
        part: impl for<'a> FnOnce(&'a C) -> Option<&'a [T]>,
    ) -> Option<Array<T>> {
        let part = Yoke::try_attach_to_cart(owner, |owner| part(owner).ok_or(())).ok()?;
        Some(Array(Held::Shared(part.erase_arc_cart())))
    }

    /// The elements, to be changed. What is shared is copied first.
    pub fn to_mut(&mut self) -> &mut Vec<T>
    where
        T: Clone,
    {
        if let Held::Shared(part) = &self.0 {
            self.0 = Held::Own(part.get().to_vec());
        }
        match &mut self.0 {
            Held::Own(own) => own,
            Held::Shared(_) => unreachable!("what was shared has just been copied"),
        }
    }

    /// Whether the elements lie in something that others may share.
    pub fn is_shared(&self) -> bool {
        matches!(self.0, Held::Shared(_))
    }
}

impl<T> Deref for Array<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Held::Own(own) => own,
            Held::Shared(part) => part.get(),
        }
    }
}

impl<T> Default for Array<T> {
    fn default() -> Array<T> {
        Array(Held::Own(Vec::new()))
    }
}

impl<T: Clone> Clone for Array<T> {
    fn clone(&self) -> Array<T> {
        Array(match &self.0 {
            Held::Own(own) => Held::Own(own.clone()),
            Held::Shared(part) => Held::Shared(part.clone()),
        })
    }
}

impl<T: fmt::Debug> fmt::Debug for Array<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self[..].fmt(f)
    }
}

impl<T: PartialEq, U: AsRef<[T]> + ?Sized> PartialEq<U> for Array<T> {
    fn eq(&self, other: &U) -> bool {
        self[..] == *other.as_ref()
    }
}

impl<T> AsRef<[T]> for Array<T> {
    fn as_ref(&self) -> &[T] {
        self
    }
}

impl<T> From<Vec<T>> for Array<T> {
    fn from(own: Vec<T>) -> Array<T> {
        Array(Held::Own(own))
    }
}

impl<T> FromIterator<T> for Array<T> {
    fn from_iter<I: IntoIterator<Item = T>>(elements: I) -> Array<T> {
        Array(Held::Own(elements.into_iter().collect()))
    }
}

impl<'a, T> IntoIterator for &'a Array<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T: Clone> IntoIterator for Array<T> {
    type Item = T;
    type IntoIter = std::vec::IntoIter<T>;

    fn into_iter(mut self) -> Self::IntoIter {
        std::mem::take(self.to_mut()).into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_keeps_its_owner_alive_and_is_copied_to_be_changed() {
        let owner = Arc::new(vec![1, 2, 3, 4]);
        let mut part = Array::shared(owner.clone(), |all| all.get(1..3)).expect("in range");
        let kept = part.clone();
        assert_eq!(Arc::strong_count(&owner), 3);
        assert_eq!(part.as_ptr(), owner[1..].as_ptr());
        part.to_mut().push(9);
        assert!(!part.is_shared() && kept.is_shared());
        drop(owner);
        assert_eq!((part, kept), (vec![2, 3, 9].into(), vec![2, 3].into()));
        assert!(Array::shared(Arc::new([0; 4]), |all| all.get(3..5)).is_none());
    }
}
