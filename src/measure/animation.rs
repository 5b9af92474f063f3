//! Objects that move while a path is measured: the same moves on every machine, from a seed.

use std::fmt;
use std::str::FromStr;

use glam::{DAffine3, DMat3, DVec3};

use crate::scene::{Move, Scene};

/// One object in so many is a door.
const OBJECTS_PER_DOOR: u64 = 64;
/// A door opens and shuts in so many frames.
const DOOR_PERIOD: f64 = 48.0;
/// What moves otherwise comes back after so many.
const SWAY_PERIOD: f64 = 31.0;
/// How far it goes, as a share of its size,
const SWAY: f64 = 0.25;
/// and how far it turns, in radians.
const TURN: f64 = 0.2;

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moving {
    /// One object in 64 turns about an upright edge of its box, by a right angle and back.
    Doors,
    /// All objects sway, and turn a little.
    All,
}

impl fmt::Display for Moving {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Moving::Doors => "doors",
            Moving::All => "all",
        })
    }
}

impl FromStr for Moving {
    type Err = String;

    fn from_str(text: &str) -> Result<Moving, String> {
        let known = [Moving::Doors, Moving::All].into_iter();
        { known }
            .find(|moving| moving.to_string() == text)
            .ok_or_else(|| "give doors or all".to_owned())
    }
}

/// Where the objects of a scene are in each frame.
#[derive(Clone, Debug)]
pub struct Animation {
    movers: Vec<Mover>,
}

/// An object that moves.
#[derive(Clone, Debug)]
struct Mover {
    object: u32,
    /// Where it stands at rest.
    rest: DAffine3,
    /// What it turns about.
    pivot: DVec3,
    axis: DVec3,
    /// The largest angle.
    turn: f64,
    /// The farthest that it goes.
    way: DVec3,
    /// Frames, there and back.
    period: f64,
    /// The share of its period that it is ahead.
    phase: f64,
}

impl Animation {
    /// Makes the objects of a scene move whose upward direction is close to this one; which, and how, comes from the seed.
    pub fn new(scene: &Scene, moving: Moving, up: DVec3, seed: u64) -> Animation {
        let up = upright(up);
        let bounds = scene.bounds();
        let mover = |(number, object): (u32, &crate::scene::Object)| {
            let chance = mixed(seed ^ mixed(u64::from(number)));
            let phase = (chance >> 32 & 0xffff) as f64 / 65_536.0;
            let rest = object.world_from_local;
            let bounds = bounds[number as usize];
            match moving {
                Moving::Doors => chance.is_multiple_of(OBJECTS_PER_DOOR).then(|| Mover {
                    object: number,
                    rest,
                    pivot: bounds.corners()[(chance >> 56 & 7) as usize],
                    axis: up,
                    turn: std::f64::consts::FRAC_PI_2,
                    way: DVec3::ZERO,
                    period: DOOR_PERIOD,
                    phase,
                }),
                Moving::All => Some(Mover {
                    object: number,
                    rest,
                    pivot: bounds.center(),
                    axis: up,
                    turn: TURN,
                    way: bounds.size() * SWAY,
                    period: SWAY_PERIOD,
                    phase,
                }),
            }
        };
        let objects = (0..).zip(scene.objects());
        Animation {
            movers: objects.filter_map(mover).collect(),
        }
    }

    /// Where the objects go in a frame.
    pub fn moves(&self, frame: usize, moves: &mut Vec<Move>) {
        moves.clear();
        moves.extend(self.movers.iter().map(|mover| mover.at(frame as f64)));
    }
}

impl Mover {
    fn at(&self, frame: f64) -> Move {
        let part = frame / self.period + self.phase;
        let wave = libm::sin(part * std::f64::consts::TAU);
        // Half the way at rest, so that it is there and back once.
        let angle = self.turn * (wave * 0.5 + 0.5);
        let turned = DAffine3::from_mat3(rotation(self.axis, angle));
        let about = DAffine3::from_translation(self.pivot + self.way * wave)
            * turned
            * DAffine3::from_translation(-self.pivot);
        Move {
            object: self.object,
            world_from_local: about * self.rest,
            swept: false,
        }
    }
}

/// The axis of the world that a direction is closest to.
fn upright(up: DVec3) -> DVec3 {
    let [x, y, z] = up.abs().to_array();
    if y >= x && y >= z {
        DVec3::Y
    } else if z >= x {
        DVec3::Z
    } else {
        DVec3::X
    }
}

/// A turn about a unit vector (Rodrigues' formula), with the same bits on every machine.
fn rotation(axis: DVec3, angle: f64) -> DMat3 {
    let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
    let turned =
        |v: DVec3| v * cosine + axis.cross(v) * sine + axis * (axis.dot(v) * (1.0 - cosine));
    DMat3::from_cols(turned(DVec3::X), turned(DVec3::Y), turned(DVec3::Z))
}

/// The mixing step of SplitMix64 (Steele, Lea and Flood, *Fast Splittable Pseudorandom Number Generators*, 2014, figure 14).
fn mixed(z: u64) -> u64 {
    let z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
