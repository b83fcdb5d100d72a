//! All integration tests, in one binary.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod case_files;
mod checkpoint;
mod cli;
mod conservation;
mod contact;
mod docs;
mod element;
mod fixture;
mod frames;
mod fuzz;
mod objectivity;
mod outcome;
mod packs;
mod regression;
mod report;
mod shaders;
mod study;
mod support;
mod symmetry;
mod unit_cell;
