//! The files of a package and their imports from each other.

use std::{
    collections::{BTreeMap, BTreeSet, VecDeque},
    fs,
    path::{Path, PathBuf},
};

use super::source::{ItemPath, paths, tokens};

/// One package of the workspace, with the paths that its files refer to outside their tests.
pub struct Package {
    name: &'static str,
    /// By module; `main.rs` beside a library is the module `main`.
    files: BTreeMap<ItemPath, File>,
}

pub struct File {
    pub path: PathBuf,
    pub tokens: Vec<String>,
    /// Resolved from the root of the target package, which is their first segment.
    pub names: Vec<ItemPath>,
}

/// All packages: name of the library, folder.
pub const PACKAGES: [(&str, &str); 7] = [
    ("actuator_fmu", "src"),
    ("identification", "identification/src"),
    ("cli", "cli/src"),
    ("fmi_export", "fmi-export/src"),
    ("fmu_build", "fmu-build/src"),
    ("bact_wing", "examples/flutter-suppression/wing/src"),
    ("robustness", "robustness/src"),
];

impl Package {
    pub fn read(name: &'static str) -> Self {
        let (_, folder) = PACKAGES.iter().find(|(other, _)| *other == name).unwrap();
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let mut modules = BTreeMap::new();
        collect(&root, &Vec::new(), &mut modules);
        let exists = |module: &ItemPath| modules.contains_key(module);
        let read = |(module, path): (&ItemPath, &PathBuf)| {
            let tokens = tokens(path);
            let names = paths(&tokens, name, module, exists);
            (module.clone(), File { path: path.clone(), tokens, names })
        };
        Self { name, files: modules.iter().map(read).collect() }
    }

    /// The files of a module and of everything below it; all files for an empty name.
    pub fn below(&self, module: &str) -> impl Iterator<Item = &File> {
        let is_below = move |path: &ItemPath| module.is_empty() || path.first().is_some_and(|first| first == module);
        self.files.iter().filter(move |(path, _)| is_below(path)).map(|(_, file)| file)
    }

    /// Modules directly below the root.
    pub fn modules(&self) -> BTreeSet<&str> {
        self.files.keys().filter_map(|module| module.first()).map(String::as_str).collect()
    }

    /// The module of the file to which a path refers: the longest that is a prefix of it.
    fn target(&self, path: &ItemPath) -> Option<&ItemPath> {
        let inside = path.strip_prefix(&[self.name.to_owned()])?;
        let longest = (0..=inside.len()).rev().find(|length| self.files.contains_key(&inside[..*length]))?;
        self.files.get_key_value(&inside[..longest]).map(|(module, _)| module)
    }

    /// Imports between files, each with a path that causes it.
    fn imports(&self) -> BTreeMap<&ItemPath, BTreeMap<&ItemPath, String>> {
        let of_file = |(module, file): (&'_ ItemPath, &'_ File)| -> BTreeMap<ItemPath, String> {
            let targets = file.names.iter().filter_map(|path| Some((self.target(path)?.clone(), path.join("::"))));
            targets.filter(|(target, _)| target != module).collect()
        };
        let key = |module: &ItemPath| self.files.get_key_value(module).map(|(module, _)| module).unwrap();
        let imports = self
            .files
            .iter()
            .map(|entry| (entry.0, of_file(entry).into_iter().map(|(target, path)| (key(&target), path)).collect()));
        imports.collect()
    }

    /// Cycles of files that import each other, each as lines of text; the shortest through each file.
    pub fn circles(&self) -> Vec<String> {
        let imports = self.imports();
        let mut reported = BTreeSet::new();
        let mut circles = Vec::new();
        for start in imports.keys() {
            if reported.contains(start) {
                continue;
            }
            // Breadth first, back to the start.
            let mut reached_from: BTreeMap<&ItemPath, &ItemPath> = BTreeMap::new();
            let mut queue = VecDeque::from([*start]);
            while let Some(module) = queue.pop_front().filter(|_| !reached_from.contains_key(start)) {
                for target in imports[module].keys() {
                    if !reached_from.contains_key(target) {
                        reached_from.insert(target, module);
                        queue.push_back(target);
                    }
                }
            }
            if !reached_from.contains_key(start) {
                continue;
            }
            let mut circle = vec![*start];
            while circle.len() == 1 || circle.last() != Some(start) {
                circle.push(reached_from[circle.last().unwrap()]);
            }
            circle.reverse();
            let line = |pair: &[&ItemPath]| {
                let (from, to) = (&self.files[pair[0]].path, &self.files[pair[1]].path);
                format!("  {} -> {} ({})", shown(from), shown(to), imports[pair[0]][pair[1]])
            };
            circles.push(circle.windows(2).map(line).collect::<Vec<_>>().join("\n"));
            reported.extend(circle);
        }
        circles
    }
}

/// A path below the workspace.
pub fn shown(path: &Path) -> String {
    path.strip_prefix(env!("CARGO_MANIFEST_DIR")).unwrap_or(path).display().to_string()
}

fn collect(folder: &Path, module: &ItemPath, into: &mut BTreeMap<ItemPath, PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let below = [&module[..], std::slice::from_ref(&name)].concat();
        if path.is_dir() {
            collect(&path, &below, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.insert(if name == "lib" { Vec::new() } else { below }, path);
        }
    }
}
