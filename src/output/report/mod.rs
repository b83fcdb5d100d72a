//! Pictures of a run: figures, `shot.svg`, surfaces of bodies and plies, and the page `report.html` with its playback.

pub(crate) mod animation;
pub(crate) mod figures;
#[cfg(feature = "report")]
mod page;
#[cfg(feature = "report")]
mod plan;
#[cfg(feature = "report")]
mod playback;
#[doc(hidden)]
pub mod plot;
pub(crate) mod surface;

#[cfg(feature = "report")]
pub use self::page::report;
#[cfg(feature = "report")]
pub(crate) use self::page::{figure, page, table};
#[cfg(feature = "report")]
#[doc(hidden)]
pub use self::plan::{behind, held};
