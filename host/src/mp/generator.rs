//! Motion generators of the MP level, in all five classes of \[Z1\] §VI.
//!
//! | class | generator | one line |
//! |---|---|---|
//! | `f**() = const` | [`Start`] | tells the ECPs to begin their own programs |
//! | `f^0(c_0)` | [`Carry`]`<`[`AsPlanned`]`>` | tight motion of a held object, from memory |
//! | `f^1(c_0, v_0)` | [`Carry`]`<`[`ByDistance`]`>` | the same, slower the nearer two tools are |
//! | `f^2(c_0, e_c)` | [`Shadow`] | a robot keeps its pose relative to another's fed-back tool |
//! | `f^2(c_0, e_c)` | [`Ask`], [`Together`], [`Home`], [`GetReady`] | requests to lists of robots, until all have answered |
//! | `f^2(c_0, e_c)` | [`Stream`] | a path, element by element, as fast as its node wants it |
//! | `f^3(c_0, e_c, v_0)` | [`Carry`]`<`[`Guarded`]`>` | carrying that slows down when the closed chain is strained |
//!
//! Where to add: a generator is a file here; its class is its `Args`, and [`mod@super::census`] lists it.

mod ask;
mod carry;
mod course;
mod home;
mod pace;
mod ready;
mod shadow;
mod stream;
mod together;
mod window;

pub use ask::Ask;
pub use carry::{Carry, Carrying, knot};
pub use course::{Carried, Course, REST_SHAPE};
pub use home::Home;
pub use pace::{AsPlanned, ByDistance, Guarded, Pace};
pub use ready::{GetReady, Readiness};
pub use shadow::{Shadow, Shadowing};
pub use stream::{Stream, Streaming};
pub use together::Together;
pub use window::{Elements, PathSource};

use super::command::Commands;

/// `f** = const`: begin the programs linked into the nodes.
pub type Start = agent::Constant<Commands>;
