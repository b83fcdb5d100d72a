//! Builds the page: the library as WebAssembly, the page's script, and the shot that it compares itself with, in one file.

fn main() -> std::process::ExitCode {
    #[cfg(not(target_family = "wasm"))]
    if let Err(error) = build::page() {
        eprintln!("error: {error}");
        return std::process::ExitCode::FAILURE;
    }
    std::process::ExitCode::SUCCESS
}

#[cfg(not(target_family = "wasm"))]
mod build {
    use std::error::Error;
    use std::io::Write;
    use std::path::{Path, PathBuf};
    use std::process::Command;
    use std::{env, fs};

    use base64::Engine;
    use base64::prelude::BASE64_STANDARD;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use ripstop::{Options, case, output};
    use serde_json::{Value, json};
    use wasm_bindgen_cli_support::Bindgen;

    const TARGET: &str = "wasm32-unknown-unknown";
    const PAGE: &str = include_str!("../page/index.html");
    const SCRIPT: &str = include_str!("../page/page.js");
    const WORKER: &str = include_str!("../page/worker.js");
    const STYLE: &str = include_str!("../../src/output/report/page.css");
    const PRESETS: &str = include_str!("../../src/cli/presets.json");
    /// The shot of the README, as the page's form makes it, too.
    const CASE: &str = include_str!("../page/case.json");

    /// Writes `target/web/ripstop.html`, or the file that the command names.
    pub(super) fn page() -> Result<(), Box<dyn Error>> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
        let to = env::args_os().nth(1).map_or_else(|| target.join("web/ripstop.html"), PathBuf::from);
        compile(&root)?;
        let library = target.join(TARGET).join("release/ripstop_web.wasm");
        let mut bindgen = Bindgen::new();
        bindgen.input_path(library).no_modules(true)?.typescript(false).remove_name_section(true);
        let mut bound = bindgen.generate_output()?;
        let (glue, library) = (bound.js().to_owned(), bound.wasm_mut().emit_wasm());
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        packed.write_all(&library)?;
        let data = json!({
            "presets": serde_json::from_str::<Value>(PRESETS)?,
            "case": serde_json::from_str::<Value>(CASE)?,
            "reference": reference()?,
        });
        let worker = json!(format!("{glue}\n{WORKER}")).to_string();
        let parts = [
            ("{{style}}", STYLE.to_owned()),
            // Nothing in a script may end it.
            ("{{data}}", data.to_string().replace("</", "<\\/")),
            ("{{worker}}", worker.replace("</", "<\\/")),
            ("{{library}}", BASE64_STANDARD.encode(packed.finish()?)),
            ("{{script}}", SCRIPT.to_owned()),
        ];
        let page = parts.into_iter().fold(PAGE.to_owned(), |page, (mark, text)| page.replacen(mark, &text, 1));
        fs::create_dir_all(to.parent().unwrap_or(Path::new(".")))?;
        output::write_whole(&to, |file| file.write_all(page.as_bytes()))?;
        println!("{}: {:.1} MB; open it in a browser", to.display(), page.len() as f64 / 1e6);
        Ok(())
    }

    /// Compiles the library to WebAssembly, with the registers of 128 bits that every browser has.
    fn compile(root: &Path) -> Result<(), Box<dyn Error>> {
        let arguments = ["build", "--release", "--locked", "--lib", "--package", "ripstop-web", "--target", TARGET];
        let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut command = Command::new(cargo);
        command.args(arguments).current_dir(root);
        command.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", "-C target-feature=+simd128");
        // What binds it to JavaScript reads a section that stripping takes away.
        let done = command.env("CARGO_PROFILE_RELEASE_STRIP", "debuginfo").status()?;
        if done.success() {
            return Ok(());
        }
        Err(format!("the library was not compiled for {TARGET}\n  help: rustup target add {TARGET}").into())
    }

    /// Velocity of the projectile in double precision on the processor, by rows of the history [m/s].
    fn reference() -> Result<Vec<f64>, Box<dyn Error>> {
        let run = Options::default().run(&case::from_str("case.json", CASE, &[])?)?;
        Ok(run.history.iter().map(|row| row.projectile_velocity).collect())
    }
}
