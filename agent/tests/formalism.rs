//! What must hold of the formalism: classes, laws, scenarios.

#[path = "formalism/cell.rs"]
mod cell;
#[path = "formalism/chance.rs"]
mod chance;
#[path = "formalism/classes.rs"]
mod classes;
#[path = "formalism/compose.rs"]
mod compose;
#[path = "formalism/laws.rs"]
mod laws;
#[path = "formalism/process.rs"]
mod process;
#[path = "formalism/select.rs"]
mod select;
#[path = "formalism/sensor.rs"]
mod sensor;
