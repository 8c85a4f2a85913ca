//! A disk that is full, for real: a small file system in memory.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// 36 units of 9 MB in all.
const WHAT: [&str; 9] =
    ["builtin:sphere_room", "--method", "light_field", "--set", "st=6", "--set", "uv=64", "--set", "capture_samples=1"];

/// A file system in memory, for as long as it is not dropped.
struct SmallDisk {
    folder: tempfile::TempDir,
}

impl SmallDisk {
    /// `None` where this user may not mount anything.
    fn mount(size: &str) -> Option<Self> {
        let disk = Self { folder: tempfile::tempdir().unwrap() };
        disk.mounted(&format!("size={size}")).then_some(disk)
    }

    fn mounted(&self, options: &str) -> bool {
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", options, "tmpfs"]).arg(self.folder.path());
        mount.output().is_ok_and(|ended| ended.status.success())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        // Where nothing was mounted this fails, as it should.
        let _ = Command::new("umount").arg(self.folder.path()).output();
    }
}

/// Why the test cannot be run here.
pub(crate) fn missing() -> Option<&'static str> {
    SmallDisk::mount("1m").is_none().then_some("this user may not mount a file system")
}

fn bake(output: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_catoptric"));
    command.arg("bake").args(WHAT).arg("-o").arg(output).output().unwrap()
}

/// First there is room for some units, then for all of them but not for the merged file beside them.
pub(crate) fn is_full() {
    let calm = tempfile::tempdir().unwrap();
    assert!(bake(&calm.path().join("room.bake")).status.success());
    let expected = fs::read(calm.path().join("room.bake")).unwrap();
    let disk = SmallDisk::mount("4m").unwrap();
    let output = disk.path("room.bake");
    let room_for_units = expected.len() as u64 + (1 << 20);
    for size in [None, Some(room_for_units)] {
        if let Some(size) = size {
            assert!(disk.mounted(&format!("remount,size={size}")));
        }
        let ended = bake(&output);
        let message = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(1), "{message}");
        assert!(message.contains("free some space") && !output.exists(), "{message}");
        let names = fs::read_dir(disk.path("room.bake.parts")).unwrap().map(|entry| entry.unwrap().file_name());
        let names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
        let units = names.iter().filter(|name| name.starts_with("unit-")).count();
        assert!(if size.is_none() { (1..36).contains(&units) } else { units == 36 }, "{names:?}");
        assert!(names.iter().all(|name| !name.ends_with(".tmp")), "nothing half-written is left: {names:?}");
    }
    assert!(disk.mounted("remount,size=64m"));
    assert!(bake(&output).status.success());
    assert!(fs::read(&output).unwrap() == expected);
}
