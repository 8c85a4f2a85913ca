//! The scripts of a bake on Slurm.

use super::error::SlurmError;
use super::place::{absolute, default_output, name, script_folder, whole_place};
use catoptric::output::shell_word;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// How often missing units are submitted again: what fails a third time fails always.
const AGAIN: u32 = 2;

/// The scripts of a bake: an array job that makes the units, and a job after it that makes missing ones again, at most
/// twice, and merges.
#[derive(Clone, Debug)]
pub struct SlurmScripts {
    /// The program, with an absolute path as all are here.
    program: PathBuf,
    /// The place of plan and units, a folder or an address.
    place: PathBuf,
    name: String,
    /// The folder of scripts and messages.
    folder: PathBuf,
    /// The merged file.
    output: PathBuf,
    tasks: u64,
    /// Options that the user gives to all jobs.
    sbatch: Vec<String>,
}

impl SlurmScripts {
    /// The scripts of the bake whose plan is in a place: a folder, or the address of an object store.
    ///
    /// * `program`: the file of the program `catoptric`, as all machines see it;
    /// * `output`: the file that units are merged into; without, `NAME.bake` beside the place `NAME.parts`;
    /// * `tasks`: the tasks among which the units are divided, at least one;
    /// * `sbatch`: options for all jobs.
    ///
    /// Scripts and messages go into the folder of the plan, or `NAME.slurm` in the current one if that is in an object
    /// store.
    ///
    /// # Errors
    /// [`SlurmError::Path`] for what scripts cannot contain, [`SlurmError::Option`] for options that they cannot
    /// contain or that would break the division into tasks.
    pub fn new(
        program: PathBuf,
        place: &str,
        output: Option<&Path>,
        tasks: u64,
        sbatch: Vec<String>,
    ) -> Result<Self, SlurmError> {
        let scripts = Self {
            program,
            place: whole_place(place),
            name: name(place).to_owned(),
            folder: script_folder(place),
            output: output.map_or_else(|| absolute(&default_output(place)), absolute),
            tasks: tasks.max(1),
            sbatch,
        };
        scripts.check()?;
        Ok(scripts)
    }

    /// The folder of scripts and messages.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The merged file.
    pub fn output(&self) -> &Path {
        &self.output
    }

    fn check(&self) -> Result<(), SlurmError> {
        for path in [&self.program, &self.place, &self.folder, &self.output] {
            // Slurm takes a backslash in the name of an output for an order not to replace anything in it.
            let unfit = |text: &str| text.chars().any(|c| c.is_control() || c == '\\');
            if path.to_str().is_none_or(unfit) {
                return Err(SlurmError::Path { path: path.display().to_string() });
            }
        }
        for option in &self.sbatch {
            let is_array = option.starts_with("--array") || (option.starts_with("-a") && !option.starts_with("--"));
            if is_array {
                let problem = "the array is made by this program; give --tasks N";
                return Err(SlurmError::Option { option: option.clone(), problem });
            }
            if option.chars().any(char::is_control) {
                let problem = "job scripts take no control characters";
                return Err(SlurmError::Option { option: format!("{option:?}"), problem });
            }
        }
        Ok(())
    }

    pub(super) fn bake_path(&self) -> PathBuf {
        self.folder.join("bake.sbatch")
    }

    pub(super) fn finish_path(&self) -> PathBuf {
        self.folder.join("finish.sbatch")
    }

    pub(super) fn files(&self) -> [(PathBuf, String); 2] {
        [(self.bake_path(), self.bake()), (self.finish_path(), self.finish())]
    }

    /// Both scripts and the commands that submit them, as text.
    pub fn listing(&self) -> String {
        let mut text = String::new();
        for (path, script) in self.files() {
            text += &format!("# {}:\n{script}\n", path.display());
        }
        let [bake, finish] = [self.bake_path(), self.finish_path()].map(|path| word(&path));
        text + &format!(
            "# Submitted so:\n# job=$(sbatch --parsable {bake})\n# sbatch --dependency=afterany:$job {finish}\n"
        )
    }

    /// The array: a task a shard.
    fn bake(&self) -> String {
        let mut script = self.head("", "slurm-%A_%a");
        script += &directive(&format!("--array=0-{}", self.tasks - 1));
        // Ahead of the time limit: tasks end by themselves, and are told from those that were killed.
        script += &directive("--signal=B:TERM@60");
        script += &self.options();
        script
            + &format!(
                "# What is done stays done: this may be killed, or run twice, at any time.\n\
                # Words behind the script's name go on the command line.\n\
                exec {} bake run {} --shard auto --progress lines \\\n  \
                --threads \"${{SLURM_CPUS_ON_NODE:-1}}\" \"$@\"\n",
                word(&self.program),
                word(&self.place)
            )
    }

    /// The job after the array.
    fn finish(&self) -> String {
        let mut script = self.head("-finish", "slurm-%j-finish") + &self.options();
        let [program, place] = [word(&self.program), word(&self.place)];
        let [bake, finish] = [self.bake_path(), self.finish_path()].map(|path| word(&path));
        let _ = write!(
            script,
            r#"# Slurm does not start crashed tasks again: this does, {AGAIN} times at most, then it gives up.
again=${{1:-0}}
# Merging reads every unit, and refuses while one is missing or damaged.
{program} bake merge {place} -o {output} && exit
if [ "$again" -ge {AGAIN} ]; then
    echo "units are missing although they were submitted again {AGAIN} times" >&2
    exit 1
fi
missing={folder}/missing-$SLURM_JOB_ID.txt
{program} bake status {place} --missing --verify >"$missing"
# 3: units are to be made. Else it was not for want of them that nothing was merged.
[ $? -eq 3 ] || exit 1
count=$(wc -l <"$missing")
tasks=$((count < {tasks} ? count : {tasks}))
array=$(sbatch --parsable --array="0-$((tasks - 1))" {bake} --units "$missing") || exit
exec sbatch --dependency="afterany:${{array%%;*}}" {finish} "$((again + 1))"
"#,
            output = word(&self.output),
            folder = word(&self.folder),
            tasks = self.tasks,
        );
        script
    }

    /// The first lines of a script.
    fn head(&self, suffix: &str, messages: &str) -> String {
        // In file names a `%` stands for something of the job's.
        let folder = self.folder.display().to_string().replace('%', "%%");
        let options = [
            format!("--job-name={}{suffix}", self.name),
            "--requeue".into(),
            "--open-mode=append".into(),
            format!("--output={folder}/{messages}.out"),
            format!("--error={folder}/{messages}.err"),
        ];
        "#!/bin/bash\n".to_owned() + &options.map(|option| directive(&option)).concat()
    }

    /// The user's options, all on one line, since some are two words.
    fn options(&self) -> String {
        let words: Vec<String> = self.sbatch.iter().map(|option| directive_word(option)).collect();
        if words.is_empty() { String::new() } else { format!("#SBATCH {}\n", words.join(" ")) }
    }
}

/// A path as a word of a shell.
fn word(path: &Path) -> String {
    shell_word(&path.to_string_lossy())
}

fn directive(option: &str) -> String {
    format!("#SBATCH {}\n", directive_word(option))
}

/// A word as Slurm reads it in scripts: its own rules, similar to those of shells.
fn directive_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%[]*".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.into(),
        false => format!("\"{}\"", word.replace('\\', r"\\").replace('"', "\\\"")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scripts(sbatch: &[&str]) -> SlurmScripts {
        SlurmScripts {
            program: "/opt/catoptric".into(),
            place: "/data/my 100%/room.parts".into(),
            name: "room".into(),
            folder: "/data/my 100%/room.parts".into(),
            output: "/data/room.bake".into(),
            tasks: 40,
            sbatch: sbatch.iter().map(|&option| option.to_owned()).collect(),
        }
    }

    #[test]
    fn the_array_runs_shards() {
        let expected = r#"#!/bin/bash
#SBATCH --job-name=room
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH "--output=/data/my 100%%/room.parts/slurm-%A_%a.out"
#SBATCH "--error=/data/my 100%%/room.parts/slurm-%A_%a.err"
#SBATCH --array=0-39
#SBATCH --signal=B:TERM@60
#SBATCH --partition=long -t 4:00:00 "--comment=a \"b\""
# What is done stays done: this may be killed, or run twice, at any time.
# Words behind the script's name go on the command line.
exec /opt/catoptric bake run '/data/my 100%/room.parts' --shard auto --progress lines \
  --threads "${SLURM_CPUS_ON_NODE:-1}" "$@"
"#;
        assert_eq!(scripts(&["--partition=long", "-t", "4:00:00", "--comment=a \"b\""]).bake(), expected);
    }

    #[test]
    fn what_scripts_cannot_contain_is_refused() {
        let refused = |scripts: SlurmScripts| scripts.check().err().map_or_else(String::new, |error| error.to_string());
        assert_eq!(refused(scripts(&["--account=a"])), "");
        assert!(refused(scripts(&["--array=0-3"])).contains("--tasks N"));
        assert!(refused(scripts(&["-a0-3"])).contains("--tasks N"));
        assert!(refused(scripts(&["--comment=a\nb"])).contains("control"));
        assert!(refused(SlurmScripts { output: "/a\nb".into(), ..scripts(&[]) }).contains("rename it"));
    }
}
