//! The typed case from the document: reads every key once, in the order of the table.

use serde_json::{Map, Value};

use super::error::{CaseError, describe, list, quote};
use super::record::Provenance;
use super::scope::{ObjectReader, WordOrObject};
use super::words::Word;
use super::{
    Accuracy, Case, Compression, ContactSampling, Crossover, Edge, Edges, Fabric, InitialDeflection, Motion, Numerics,
    Output, Pack, Projectile, RunUntil, Shape, Shear, Solver, StretchSampling, Yarn,
};
use super::{expect, grading, layup, limits, projectile, variability};

/// Coefficient of the shock viscosity.
const VISCOSITY: f64 = 0.3;
/// The same where a bar strikes. The pulse that its kink sends out at the start runs on along the strip, where that of a round body spreads over a
/// ply: with 0.3 it stands 30 % above the exact tension. The step is a third shorter (benches/NOTES.md).
const VISCOSITY_ALONG_A_BAR: f64 = 0.8;
/// A shot whose case names no end and whose outcome is not known ends here [s].
const LONGEST: f64 = 1e-3;
/// The same where no ply spans between two clamped sides. What nothing holds stops the projectile when all of it moves: 150 mm at 50 m/s take
/// 5.2 ms. What one side holds swings first: 100 mm at 120 m/s take 2.5 ms.
const LONGEST_LOOSE: f64 = 8e-3;
/// Length along a yarn over which its failure is judged [m]; assumed. Measured in benches/NOTES.md.
const FAILURE_LENGTH: f64 = 0.9e-3;
/// Elements along a side of a crossover around the hit, and where the result is to be converged.
const FINE: u32 = 4;
const CONVERGED: u32 = 8;
/// The same where a point strikes. A tip is held late where no node is under it; with four, oblique cones have limits 6 % below those with eight,
/// with six 1 % (benches/NOTES.md).
const UNDER_A_POINT: u32 = 6;
/// The same, on an even mesh, where a bar strikes: the fewest with which strips break within 15 % of the closed form (benches/NOTES.md).
const ALONG_A_BAR: u32 = 2;

/// A case from its document, fabric inlined and changes applied; `as_run` and the names are the caller's.
pub(super) fn case(map: &Map<String, Value>) -> Result<Case, CaseError> {
    let record = Provenance::new(map.get("sources"));
    let root = ObjectReader::root(&record, map);
    let title = root.text("title")?;
    let fabric = fabric(&root.object("fabric")?, &record)?;
    let projectile = root.object_if_given("projectile")?.map(|scope| projectile::read(&scope)).transpose()?;
    let variability = root.object_if_given("variability")?;
    let variability = variability.map(|scope| variability::read(&scope, projectile.as_ref())).transpose()?;
    let scope = root.object("solver")?;
    let mut solver = solver(&scope, is_bar(projectile.as_ref()))?;
    let pack = pack(&root.object("pack")?, &fabric, projectile.as_ref(), &solver, &record)?;
    solver.end_time = end_time(&scope, &solver, projectile.as_ref(), &pack)?;
    let output = output(&root.object("output")?)?;
    let expect = root.quiet_items("expect")?.iter().map(expect::read).collect::<Result<_, _>>()?;
    root.raw("sources")?;
    for remark in ["$schema", "notes"] {
        if root.given(remark).is_some() {
            root.text(remark)?;
        }
    }
    let fields = record.into_fields();
    let (name, as_run, path, notes, drawn) = Default::default();
    Ok(Case {
        name,
        title,
        fabric,
        pack,
        projectile,
        variability,
        drawn,
        solver,
        output,
        expect,
        fields,
        as_run,
        notes,
        path,
    })
}

/// A fabric written out in the case.
pub(super) fn fabric(scope: &ObjectReader<'_>, record: &Provenance) -> Result<Fabric, CaseError> {
    let name = scope.text("name")?;
    let fibre_density = scope.number("fibre_density_kg_m3")?;
    let areal_density = scope.number_if_given("areal_density_g_m2")?;
    let warp = yarn(&scope.object("warp")?)?;
    let weft = yarn(&scope.object("weft")?)?;
    if !warp.present && !weft.present {
        let error = CaseError::at(&scope.pointer, "at least one yarn", "both absent");
        return Err(error.help("leave \"absent\" out of \"warp\" or \"weft\""));
    }
    let areal_density = match areal_density {
        Some(given) => given,
        None => {
            let per_area = |yarn: &Yarn, other: &Yarn| yarn.linear_density * (1.0 + yarn.crimp) * other.count;
            let assumed = record.any_assumed_below(&[&scope.at("warp"), &scope.at("weft")]);
            scope.derive("areal_density_g_m2", per_area(&warp, &weft) + per_area(&weft, &warp), assumed)?
        }
    };
    let crossover = crossover(&scope.object("crossover")?)?;
    let (thickness, shear) = thickness_and_shear(scope, record)?;
    Ok(Fabric { name, fibre_density, areal_density, warp, weft, crossover, shear, thickness })
}

fn yarn(scope: &ObjectReader<'_>) -> Result<Yarn, CaseError> {
    if scope.flag("absent")? {
        let count = scope.one_of("count")?;
        // A yarn that carries nothing, weighs nothing and never breaks.
        let (linear_density, modulus, failure_strain, crimp) = (0.0, 0.0, 1.0, 0.0);
        return Ok(Yarn { present: false, linear_density, modulus, failure_strain, count, crimp });
    }
    Ok(Yarn {
        present: true,
        linear_density: scope.one_of("linear density")?,
        modulus: scope.number("modulus_gpa")?,
        failure_strain: scope.number("failure_strain")?,
        count: scope.one_of("count")?,
        crimp: scope.number("crimp")?,
    })
}

fn crossover(scope: &ObjectReader<'_>) -> Result<Crossover, CaseError> {
    let law = scope.word("law")?;
    let membrane_force = scope.word("membrane_force")?;
    let gap = scope.number("gap_mm")?;
    let compression = match scope.choice("compression")? {
        WordOrObject::Word(_) => None,
        WordOrObject::Keys(keys) => compression(&keys)?,
    };
    Ok(Crossover { law, membrane_force, gap, compression })
}

/// Least b over a of (21) [N^(1/3)]: its cube is the force at which a crossover begins to stiffen, and has to be a number in single precision.
const LEAST_COMPRESSION: f64 = 1e-6;

fn compression(scope: &ObjectReader<'_>) -> Result<Option<Compression>, CaseError> {
    let (a, b) = (scope.number("a_mm")?, scope.number("b_mm_n13")?);
    match (a > 0.0, b > 0.0) {
        (true, true) if b < LEAST_COMPRESSION * a => {
            let expected = format!("b_mm_n13 at least {LEAST_COMPRESSION:e} of a_mm, or both 0");
            let error = CaseError::at(&scope.pointer, expected, format!("{:e} of it", b / a));
            Err(error.help("at the first touch such a crossover would be softer than numbers can tell"))
        }
        (true, true) => Ok(Some(Compression { a, b })),
        (false, false) => Ok(None),
        (a_positive, _) => {
            let found = if a_positive { "b_mm_n13 = 0 with a_mm > 0" } else { "a_mm = 0 with b_mm_n13 > 0" };
            let error = CaseError::at(&scope.pointer, "a_mm and b_mm_n13 both above 0, or both 0", found);
            Err(error.help("write \"compression\": \"rigid\" for a crossover without compression"))
        }
    }
}

/// The thickness may stand with the fabric or with its shear; both must agree.
fn thickness_and_shear(scope: &ObjectReader<'_>, record: &Provenance) -> Result<(f64, Option<Shear>), CaseError> {
    let choice = scope.choice("shear")?;
    let WordOrObject::Keys(keys) = choice else {
        return Ok((scope.number("thickness_mm")?, None));
    };
    let own = keys.number_if_given("thickness_mm")?;
    let thickness = match own {
        Some(own) if scope.given("thickness_mm").is_none() => {
            let assumed = record.is_assumed(&keys.at("thickness_mm"));
            scope.derive_as("thickness_mm", own, "shear's thickness_mm", assumed)?
        }
        _ => scope.number("thickness_mm")?,
    };
    match own {
        Some(own) if own != thickness => {
            let expected = format!("the thickness at {}", scope.at("thickness_mm"));
            let found = keys.given("thickness_mm").map(describe).unwrap_or_default();
            let help = "give one of the two: a fabric has one thickness";
            return Err(CaseError::at(keys.at("thickness_mm"), expected, found).help(help));
        }
        Some(_) => {}
        None => {
            keys.derive("thickness_mm", thickness, record.is_assumed(&scope.at("thickness_mm")))?;
        }
    }
    let shear = Shear {
        g1: keys.number("g1_mpa")?,
        g2: keys.number("g2_mpa")?,
        gamma1: keys.number("gamma1")?,
        gamma2: keys.number("gamma2")?,
        modulus: keys.word("modulus")?,
    };
    for (low, high, ordered) in
        [("g1_mpa", "g2_mpa", shear.g1 <= shear.g2), ("gamma1", "gamma2", shear.gamma1 <= shear.gamma2)]
    {
        if !ordered {
            let text = |name: &str| record.value(&keys.at(name));
            let expected = format!("at most {high}, which is {}", text(high));
            return Err(CaseError::at(keys.at(low), expected, text(low)));
        }
    }
    Ok((thickness, Some(shear)))
}

fn pack(
    scope: &ObjectReader<'_>,
    fabric: &Fabric,
    projectile: Option<&Projectile>,
    solver: &Solver,
    record: &Provenance,
) -> Result<Pack, CaseError> {
    let size = [scope.number("width_mm")?, scope.number("height_mm")?];
    let edges = edges(scope)?;
    let crossovers_per_element = scope.whole("crossovers_per_element")?;
    let bar = is_bar(projectile);
    let finer = solver.numerics == Numerics::Default && crossovers_per_element == 1 && projectile.is_some();
    // A bar meets whole rows of nodes, and sends waves along the whole of the strip: its mesh is even.
    let graded = finer && !bar;
    let elements_per_crossover = match scope.given("elements_per_crossover") {
        Some(_) => scope.whole("elements_per_crossover")?,
        None => {
            let count = match (finer, solver.accuracy) {
                (false, _) => 1,
                (true, Accuracy::Default) if bar => ALONG_A_BAR,
                (true, Accuracy::Default) if projectile.is_some_and(|p| p.shape.is_pointed()) => UNDER_A_POINT,
                (true, Accuracy::Default) => FINE,
                (true, Accuracy::Converged) => CONVERGED,
            };
            scope.derive_value("elements_per_crossover", count.to_string(), false)?;
            count
        }
    };
    let side = f64::from(crossovers_per_element) / f64::from(elements_per_crossover);
    let ([columns, rows], [element_length_x, element_length_y]) = mesh(scope, fabric, size, side)?;
    let pretension = scope.object("pretension")?;
    let pretension = [pretension.number_if_given("warp_n_per_m")?, pretension.number_if_given("weft_n_per_m")?];
    let initial_velocity = scope.vector("initial_velocity_m_s")?;
    let initial_deflection = scope.object_if_given("initial_deflection")?;
    let common = layup::Common { fabric, size, side, edges, initial_velocity };
    let mut layup = layup::read(scope, &common, record)?;
    let plies = layup::plies(scope, &layup)?;
    let spacing = scope.number_if_given("spacing_mm")?;
    match spacing {
        Some(_) => {}
        None if layup.is_empty() => {
            scope.derive("spacing_mm", fabric.thickness, record.is_assumed("/fabric/thickness_mm"))?;
        }
        None => layup::derive_spacing(scope, &layup, record)?,
    }
    let depth = f64::from(plies - 1) * spacing.unwrap_or_else(|| layup::thickest(&layup, fabric));
    let grading = grading::read(scope, projectile, side, graded)?.map(|g| g.through(depth, size, projectile));
    for layer in &mut layup {
        layer.grading = grading;
    }
    Ok(Pack {
        plies,
        spacing,
        friction: scope.number("friction")?,
        layup,
        columns,
        rows,
        element_length_x,
        element_length_y,
        crossovers_per_element,
        grading,
        elements_per_crossover,
        edges,
        pretension: pretension.iter().any(Option::is_some).then_some(pretension),
        initial_velocity,
        initial_deflection: initial_deflection.map(|scope| deflection(&scope)).transpose()?,
    })
}

/// Columns and rows, and the element lengths [m], for a size [m]: of the pack or of a group of its plies; `side` is the
/// number of crossovers along the side of an element.
pub(super) fn mesh(
    scope: &ObjectReader<'_>,
    fabric: &Fabric,
    size: [f64; 2],
    side: f64,
) -> Result<([usize; 2], [f64; 2]), CaseError> {
    let length = [&fabric.warp, &fabric.weft].map(|yarn| side * 2.0 * yarn.half_span());
    // Finer meshes cover the same cloth: whole crossovers.
    let fine = (1.0 / side).round().max(1.0) as usize;
    let count = limits::mesh(&scope.pointer, size, length, fine)?;
    let how = "the size over the element length, to the nearest whole number of crossovers";
    for (name, count) in [("columns", count[0]), ("rows", count[1])] {
        scope.derive_text(name, count.to_string(), how);
    }
    Ok((count, length))
}

pub(super) fn edges(scope: &ObjectReader<'_>) -> Result<Edges, CaseError> {
    let (left, right, bottom, top) = match scope.choice("edges")? {
        WordOrObject::Word(word) => {
            let unknown = || CaseError::at(scope.at("edges"), list(Edge::WORDS.iter().copied()), quote(&word));
            let all = Edge::from_word(&word).ok_or_else(unknown)?;
            (all, all, all, all)
        }
        WordOrObject::Keys(keys) => (keys.word("left")?, keys.word("right")?, keys.word("bottom")?, keys.word("top")?),
    };
    Ok(Edges { left, right, bottom, top })
}

fn deflection(scope: &ObjectReader<'_>) -> Result<InitialDeflection, CaseError> {
    Ok(InitialDeflection {
        amplitude: scope.number("amplitude_mm")?,
        warp_half_waves: scope.whole("warp_half_waves")?,
        weft_half_waves: scope.whole("weft_half_waves")?,
    })
}

/// The end of the run [s].
fn end_time(
    scope: &ObjectReader<'_>,
    solver: &Solver,
    projectile: Option<&Projectile>,
    pack: &Pack,
) -> Result<f64, CaseError> {
    if let Some(given) = scope.number_if_given("end_time_us")? {
        return Ok(given);
    }
    let decided = projectile.is_some_and(|p| p.motion == Motion::Free) && solver.run_until != RunUntil::EndTime;
    if !decided {
        let error = CaseError::at(scope.at("end_time_us"), "the end of the run", "nothing");
        return Err(error.help("no outcome ends this run: it has no free projectile, or run_until is \"end_time\""));
    }
    let spans =
        if pack.layup.is_empty() { pack.edges.span() } else { pack.layup.iter().any(|layer| layer.edges.span()) };
    scope.derive("end_time_us", if spans { LONGEST } else { LONGEST_LOOSE }, false)
}

fn is_bar(projectile: Option<&Projectile>) -> bool {
    projectile.is_some_and(|p| matches!(p.shape, Shape::Bar { .. }))
}

/// Everything of the solver but when it ends. `bar`: whether a bar strikes.
fn solver(scope: &ObjectReader<'_>, bar: bool) -> Result<Solver, CaseError> {
    let numerics = scope.word("numerics")?;
    let paper = numerics == Numerics::Paper;
    let viscosity = match (paper, bar) {
        (true, _) => 0.0,
        (false, true) => VISCOSITY_ALONG_A_BAR,
        (false, false) => VISCOSITY,
    };
    let run_until = scope.word("run_until")?;
    Ok(Solver {
        numerics,
        accuracy: scope.word("accuracy")?,
        end_time: LONGEST,
        courant: scope.number("courant")?,
        hourglass: scope.number("hourglass")?,
        shock_viscosity: scope.number_or("shock_viscosity", viscosity, false)?,
        failure_length: scope.number_or("failure_length_mm", if paper { 0.0 } else { FAILURE_LENGTH }, !paper)?,
        symmetry: scope.word("symmetry")?,
        contact_sampling: word_or(
            scope,
            "contact_sampling",
            if paper { ContactSampling::Nodes } else { ContactSampling::Edges },
        )?,
        stretch_sampling: word_or(
            scope,
            "stretch_sampling",
            if paper { StretchSampling::Centre } else { StretchSampling::Mean },
        )?,
        run_until,
    })
}

/// The word of a key, or what follows from other keys where it is left out.
fn word_or<W: Word>(scope: &ObjectReader<'_>, key: &'static str, otherwise: W) -> Result<W, CaseError> {
    if scope.given(key).is_some() {
        return scope.word(key);
    }
    scope.derive_value(key, otherwise.word().to_owned(), false)?;
    Ok(otherwise)
}

fn output(scope: &ObjectReader<'_>) -> Result<Output, CaseError> {
    let output = Output {
        history_interval: scope.number("history_interval_us")?,
        frames: scope.whole("frames")?,
        profile_times: scope.numbers("profile_times_us")?.unwrap_or_default(),
        profile_along: scope.word("profile_along")?,
    };
    if let Some(index) = output.profile_times.windows(2).position(|pair| pair[0] >= pair[1]) {
        let item = scope.given("profile_times_us").and_then(|list| list.get(index + 1));
        let location = format!("{}/{}", scope.at("profile_times_us"), index + 1);
        let expected = format!("more than item {} of {}: ascending times", index, quote("profile_times_us"));
        return Err(CaseError::at(location, expected, item.map(describe).unwrap_or_default()));
    }
    Ok(output)
}
