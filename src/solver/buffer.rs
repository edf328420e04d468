//! What only saves allocation or time.

use core::ops::{Deref, DerefMut};

/// Reused memory, or threads that are lent, beside the state that decides the next frame. Nothing of it decides that, or it is
/// found again with the same bits. So any two are equal, a clone is empty, and nothing of it is recorded.
#[derive(Debug, Default)]
pub(super) struct Buffer<T>(pub T);

impl<T> Deref for Buffer<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T> DerefMut for Buffer<T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.0
    }
}

impl<T: Default> Clone for Buffer<T> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<T> PartialEq for Buffer<T> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

#[cfg(feature = "record")]
impl<T> serde::Serialize for Buffer<T> {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_unit()
    }
}

#[cfg(feature = "record")]
impl<'de, T: Default> serde::Deserialize<'de> for Buffer<T> {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        <()>::deserialize(from).map(|()| Self::default())
    }
}

/// Makes room for half as many again as there were, when little of it is left.
pub(super) fn keep_room<T>(list: &mut Vec<T>, were: usize) {
    keep_room_up_to(list, were, usize::MAX);
}

/// The same, for no more than `most`.
pub(super) fn keep_room_up_to<T>(list: &mut Vec<T>, were: usize, most: usize) {
    if list.capacity() < (were + were / 4).min(most) {
        list.reserve_exact((were + were / 2).min(most).saturating_sub(list.len()));
    }
}
