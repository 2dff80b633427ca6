//! `fmu-build`: arguments to one library call, then a short summary. It makes no decisions.

#![forbid(unsafe_code)]

use clap::{
    Args, Parser, Subcommand,
    builder::{PossibleValuesParser, TypedValueParser as _},
};
use fmu_build::{Archive, Options, Platform, Result, platform::glibc};
use std::{
    io::Write as _,
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Exit code for bad usage and bad input; clap uses the same.
const FAILURE: u8 = 2;

/// Package a Rust library as an FMI 2.0 FMU, as its Cargo.toml describes it.
#[derive(Parser)]
#[command(version, args_conflicts_with_subcommands = true, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    build: Build,
}

#[derive(Subcommand)]
enum Command {
    /// List what is inside an FMU
    #[command(after_help = "Example:\n  fmu-build inspect target/fmu/Pendulum.fmu")]
    Inspect {
        /// The FMU
        fmu: PathBuf,
    },
}

#[derive(Args)]
struct Build {
    /// Folder of the package, or its Cargo.toml
    #[arg(default_value = ".")]
    package_dir: PathBuf,
    /// Where to write [default: <target directory>/fmu/<model identifier>.fmu]
    #[arg(short, long, value_name = "F.fmu")]
    output: Option<PathBuf>,
    /// Compile for this platform, to run on other computers as well; may be repeated; `all` means linux64, win64, darwin64
    /// and aarch64-linux [default: for this computer]
    #[arg(long = "platform", value_name = "PLATFORM", value_parser = platform_parser())]
    platforms: Vec<Platforms>,
    /// Replace the file named by --output
    #[arg(long)]
    force: bool,
}

const EXAMPLES: &str = r#"Examples:
  fmu-build                                    package the library in this folder
  fmu-build pendulum -o p.fmu                  package another one, under another name
  fmu-build --platform linux64 --platform win64
  fmu-build --platform all
  fmu-build inspect p.fmu                      list what is inside

With cargo-zigbuild on the PATH (pip install ziglang cargo-zigbuild) a Linux binary needs no glibc newer than 2.17,
and darwin64 and aarch64-linux can be linked from here. `rustup target add` brings the Rust targets.

Cargo.toml of the package:
  [package.metadata.fmu]
  model-identifier = "Pendulum"
  description = "modelDescription.xml"
  # optional: icon, documentation, licenses, resources, extra, profile, features"#;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let outcome = match cli.command {
        Some(Command::Inspect { fmu }) => inspect(&fmu),
        None => build(cli.build),
    };
    match outcome {
        Ok(text) => {
            // A reader that has stopped reading, such as `head`, is not an error.
            let _ = std::io::stdout().write_all(text.as_bytes());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(FAILURE)
        }
    }
}

fn build(build: Build) -> Result<String> {
    let Build { package_dir, output, platforms, force } = build;
    let platforms = platforms.into_iter().flat_map(|platforms| platforms.0).collect();
    let path = fmu_build::build(package_dir, &Options { platforms, output, force })?;
    let archive = Archive::read(&path)?;
    let binaries: Vec<_> = Platform::ALL
        .into_iter()
        .filter_map(|platform| {
            let folder = format!("binaries/{platform}/");
            archive.entries().find(|(name, _)| name.starts_with(&folder)).map(|(_, bytes)| (platform, bytes))
        })
        .collect();
    let folders: Vec<_> = binaries.iter().map(|(platform, _)| platform.folder()).collect();
    let mut text = format!(
        "{}\n  size       {}\n  platforms  {}\n  entries    {}\n",
        path.display(),
        file_size(&path),
        folders.join(", "),
        archive.names().count()
    );
    for (platform, bytes) in binaries {
        if let Some(version) = glibc::needed(bytes).filter(|_| platform.has_glibc()) {
            text += &format!("  {platform} needs glibc {version} or newer\n");
        }
        if Platform::host().ok() != Some(platform) {
            text += &format!("  {platform} is only linked: this computer cannot run it\n");
        }
    }
    Ok(text)
}

fn inspect(path: &Path) -> Result<String> {
    let archive = Archive::read(path)?;
    let mut text = format!("{:>12}  entry\n", "bytes");
    let mut total = 0;
    for (name, bytes) in archive.entries() {
        total += bytes.len();
        text += &format!("{:>12}  {name}\n", bytes.len());
    }
    text += &format!("{total:>12}  unpacked, {} packed\n", file_size(path));
    Ok(text)
}

fn file_size(path: &Path) -> String {
    path.metadata().map_or("unknown".into(), |metadata| format!("{:.1} kB", metadata.len() as f64 / 1000.0))
}

/// The value of one `--platform`: one, or all.
#[derive(Clone)]
struct Platforms(Vec<Platform>);

const ALL: &str = "all";

fn platform_parser() -> impl clap::builder::TypedValueParser<Value = Platforms> {
    PossibleValuesParser::new(Platform::ALL.map(Platform::folder).into_iter().chain([ALL])).try_map(
        |word| -> Result<Platforms> {
            Ok(Platforms(if word == ALL { Platform::COMMON.to_vec() } else { vec![word.parse()?] }))
        },
    )
}
