//! What C hands over, checked: pointers that must not be null, places for results, choices from a list, numbers in a range.

use std::fmt::Display;
use std::mem::MaybeUninit;
use std::ops::RangeInclusive;

use antumbra::glam::{DAffine3, DMat4, DVec3, DVec4};

use crate::borrow;
use crate::status::AntumbraStatus::ANTUMBRA_ERROR_NULL_POINTER;
use crate::status::Error;

/// A pointer that must not be null.
pub fn required<T>(pointer: Option<T>, name: &str) -> Result<T, Error> {
    pointer.ok_or_else(|| {
        let message = format_args!("{name} must not be NULL");
        Error::new(ANTUMBRA_ERROR_NULL_POINTER, message)
    })
}

/// Where a handle is to be put: NULL until there is one.
pub fn empty<'a, T>(
    place: Option<&'a mut MaybeUninit<Option<Box<T>>>>,
    name: &str,
) -> Result<&'a mut Option<Box<T>>, Error> {
    Ok(required(place, name)?.write(None))
}

/// Where a list's address and length are to be put: NULL and 0 until there is one that has elements.
pub struct ListPlace<'a, T> {
    address: &'a mut *const T,
    count: &'a mut usize,
}

impl<'a, T> ListPlace<'a, T> {
    pub fn empty(
        address: Option<&'a mut MaybeUninit<*const T>>,
        count: Option<&'a mut MaybeUninit<usize>>,
    ) -> Result<ListPlace<'a, T>, Error> {
        let address = required(address, "where a list is to be put")?;
        let count = required(count, "where a list's length is to be put")?;
        Ok(ListPlace {
            address: address.write(std::ptr::null()),
            count: count.write(0),
        })
    }

    pub fn put(self, list: &[T]) {
        if !list.is_empty() {
            *self.address = list.as_ptr();
            *self.count = list.len();
        }
    }
}

/// What a number from a list of choices stands for.
pub fn chosen<V: Copy>(value: u32, choices: &[(u32, V)], what: &str) -> Result<V, Error> {
    let found = choices.iter().find(|(number, _)| *number == value);
    found
        .map(|(_, choice)| *choice)
        .ok_or_else(|| Error::invalid(format_args!("{what} is {value}, which is no choice")))
}

/// A number in a range; NaN is in none.
pub fn within<T: PartialOrd + Display>(
    value: T,
    range: RangeInclusive<T>,
    what: &str,
) -> Result<T, Error> {
    if range.contains(&value) {
        return Ok(value);
    }
    let (least, most) = range.into_inner();
    Err(Error::invalid(format_args!(
        "{what} is {value}, but must be from {least} to {most}"
    )))
}

/// Three numbers.
pub fn vector(numbers: *const f64, name: &str) -> Result<DVec3, Error> {
    Ok(DVec3::from_slice(borrow::list(numbers, 3, name)?))
}

/// Sixteen numbers, column by column, whose last row is 0 0 0 1.
pub fn affine(numbers: *const f64, name: &str) -> Result<DAffine3, Error> {
    let matrix = DMat4::from_cols_slice(borrow::list(numbers, 16, name)?);
    if !matrix.is_finite() {
        return Err(Error::invalid(format_args!(
            "{name} has a number that is not finite"
        )));
    }
    if matrix.row(3) != DVec4::W {
        return Err(Error::invalid(format_args!(
            "the last row of {name} must be 0 0 0 1; are its numbers row by row? They must be column by column"
        )));
    }
    Ok(DAffine3::from_mat4(matrix))
}

/// The same; NULL is the identity.
pub fn placement(numbers: *const f64, name: &str) -> Result<DAffine3, Error> {
    if numbers.is_null() {
        return Ok(DAffine3::IDENTITY);
    }
    affine(numbers, name)
}
