//! The shaders against their Rust twins, without a graphics adapter: what both sides of the fence have written down.
//!
//! Goes red when a kernel no longer compiles, binds other buffers than the host gives it, lays a struct out in another
//! way than the host fills it, or has another value of a shared constant.

mod constants;
mod layouts;

use std::collections::BTreeMap;
use std::path::Path;

use naga::{AddressSpace, Module, StorageAccess};
use ripstop::case::Case;
use ripstop::gpu::shader::{Access, KERNELS, Kernel};
use ripstop::gpu::stepper::DeviceStepper;
use ripstop::gpu::{Device, layout};
use ripstop::model::Model;
use wgpu::naga;

use crate::support::builtin;
use crate::support::patch;

fn parse(kernel: &Kernel) -> Module {
    let source = kernel.source();
    naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)))
}

fn modules() -> Vec<(&'static str, Module)> {
    KERNELS.iter().map(|kernel| (kernel.name, parse(kernel))).collect()
}

/// Scenes that between them fill every word of the uniforms.
fn cases() -> Vec<Case> {
    let mut patch = patch::case(3, 2);
    patch.pack.edges.left = ripstop::case::Edge::Clamped;
    patch.pack.edges.right = ripstop::case::Edge::Roller;
    patch.pack.edges.bottom = ripstop::case::Edge::Roller;
    patch.pack.edges.top = ripstop::case::Edge::Clamped;
    patch.fabric.crossover.gap = 1e-5;
    let shot = |sets: &[&str]| builtin("cases/s720-1ply-155.json", sets);
    let bar = shot(&["/projectile/friction=0.2", "/projectile/motion=prescribed"]);
    let mut moving = bar.clone();
    if let Some(p) = &mut moving.projectile {
        p.obliquity = 0.3;
        p.azimuth = 0.4;
        p.shape = ripstop::case::Shape::Bar { diameter: 5e-3, along: ripstop::case::Along::Warp };
        p.edge_radius = 0.0;
    }
    let nose = |shape: &str| {
        let set = format!(
            "/projectile={{\"shape\":\"{shape}\",\"diameter_mm\":6,\"length_mm\":12,\"mass_g\":2,\"velocity_m_s\":150}}"
        );
        shot(&[&set])
    };
    let layup = r#"/pack/layup=[{"plies":2},{"plies":2,"orientation_deg":30,"edges":"free"}]"#;
    let rim = shot(&["/solver/contact_sampling=edges"]);
    let pack = shot(&[layup, "/pack/plies=4"]);
    vec![patch, bar, moving, pack, nose("ogive"), nose("fragment"), rim, graded()]
}

/// Turned plies, longer along one side.
fn graded() -> Case {
    let layup = r#"/pack/layup=[{},{"orientation_deg":30}]"#;
    builtin(
        "cases/s720-1ply-155.json",
        &[
            "/pack/plies=2",
            layup,
            "/pack/width_mm=150",
            "/pack/mesh_grading=graded",
            "/solver/shock_viscosity=0.3",
            "/solver/failure_length_mm=2",
        ],
    )
}

#[test]
fn every_kernel_compiles_within_what_every_device_offers() {
    for (name, module) in modules() {
        // Packing two halves into a word is part of WGSL.
        let capabilities = naga::valid::Capabilities::SHADER_FLOAT16_IN_FLOAT32;
        let flags = naga::valid::ValidationFlags::all();
        let checked = naga::valid::Validator::new(flags, capabilities).validate(&module);
        checked.unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string("")));
    }
}

#[test]
fn entry_points_have_the_names_and_sizes_the_host_dispatches() {
    for (name, module) in modules() {
        let [entry] = &module.entry_points[..] else { panic!("{name}: one entry point is expected") };
        assert_eq!(entry.name, name);
        if name.starts_with("projectile_") {
            let width = entry.workgroup_size_overrides.unwrap()[0].unwrap();
            let naga::Expression::Override(width) = module.global_expressions[width] else { panic!("{name}") };
            assert_eq!(module.overrides[width].name.as_deref(), Some("WIDTH"), "{name}");
        } else {
            let group = if name == "sweep" { 256 } else { layout::GROUP };
            assert_eq!(entry.workgroup_size, [group, 1, 1], "{name}");
        }
    }
}

#[test]
fn bindings_are_those_the_host_makes() {
    for kernel in &KERNELS {
        let module = parse(kernel);
        let mut found = BTreeMap::new();
        for (_, variable) in module.global_variables.iter() {
            let Some(binding) = &variable.binding else { continue };
            let access = match variable.space {
                AddressSpace::Uniform | AddressSpace::Handle => None,
                AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => Some(Access::Write),
                AddressSpace::Storage { .. } => Some(Access::Read),
                space => panic!("{}: {space:?}", kernel.name),
            };
            found.insert((binding.group, binding.binding), (variable.name.clone().unwrap_or_default(), access));
        }
        let own = kernel
            .bindings
            .iter()
            .zip(0..)
            .map(|((name, access), at)| ((1, at), (name.variable().to_owned(), Some(*access))));
        let names: &[&str] = match kernel.name {
            "sweep" | "yarn_load" => &["scene", "step", "plies", "grid_lines", "law"],
            _ => &["scene", "step", "plies", "grid_lines"],
        };
        let common = names.iter().zip(0..).chain([(&"shots", 5)]);
        let common = common.map(|(name, at)| ((0, at), ((*name).to_owned(), None)));
        assert_eq!(found, common.chain(own).collect(), "{}", kernel.name);
        assert!(kernel.bindings.len() <= 10, "{}: a device is asked for ten storage buffers", kernel.name);
    }
}

#[test]
fn every_file_belongs_to_a_kernel_and_names_its_twin() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for entry in std::fs::read_dir(root.join("shaders")).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        assert!(KERNELS.iter().any(|k| k.sources.contains(&text.as_str())), "{name} is in no kernel");
        assert!(text.starts_with(&format!("// {name}: ")), "{name} begins with another name");
        let twin = text.lines().find_map(|l| l.strip_prefix("// Twin: ")).unwrap_or_else(|| panic!("{name}: no twin"));
        let files: Vec<_> = twin.split([' ', ',']).filter(|word| word.starts_with("src/")).collect();
        assert!(!files.is_empty() && files.iter().all(|f| root.join(f).is_file()), "{name}: {twin}");
    }
    for kernel in &KERNELS {
        let own = std::fs::read_to_string(root.join(format!("shaders/{}.wgsl", kernel.name))).unwrap();
        assert_eq!(
            kernel.sources[0], own,
            "{}: its own file comes first, so that line numbers stay right",
            kernel.name
        );
    }
}

#[test]
fn pipelines_and_bindings_fit_together_for_every_kind_of_scene() {
    let device = Device::noop();
    let mut cases = cases();
    cases.extend(crate::support::SOLVER_LAWS.map(|law| {
        let mut case = patch::bare(patch::case(2, 3));
        (case.fabric.crossover.law, case.fabric.crossover.compression) = (law, None);
        case
    }));
    for case in cases {
        let model = Model::<f32>::new(&case).unwrap();
        DeviceStepper::new(&device, &model).map(|_| ()).unwrap_or_else(|e| panic!("{}: {e}", case.title));
        let broken =
            |kernel: &Kernel| kernel.source().replace("var<storage, read> cells", "var<storage, read_write> cells");
        let refused = DeviceStepper::with_sources(&device, &model, 1, &broken);
        assert!(refused.is_err(), "a binding that does not fit is refused");
    }
}
