//! Bakes on a disk that is full, for real: a small file system in memory.
//!
//! Where nothing may be mounted this test shows as ignored, with the reason.

#![cfg_attr(target_os = "linux", expect(clippy::unwrap_used, reason = "a test that cannot go on must fail"))]

fn main() {
    let arguments = libtest_mimic::Arguments::from_args();
    #[cfg(target_os = "linux")]
    let trials = vec![linux::trial()];
    #[cfg(not(target_os = "linux"))]
    let trials = Vec::new();
    libtest_mimic::run(&arguments, trials).exit();
}

#[cfg(target_os = "linux")]
mod linux {
    use libtest_mimic::Trial;
    use std::fs;
    use std::path::{Path, PathBuf};
    use std::process::{Command, Output};

    /// 36 units of 9 MB in all.
    const WHAT: [&str; 9] = [
        "builtin:sphere_room",
        "--method",
        "light_field",
        "--set",
        "st=6",
        "--set",
        "uv=64",
        "--set",
        "capture_samples=1",
    ];

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

    /// The test, ignored where nothing may be mounted.
    pub(crate) fn trial() -> Trial {
        let name = "a disk that is full keeps whole units, and the bake goes on once there is room";
        match SmallDisk::mount("1m") {
            Some(_) => Trial::test(name, || {
                is_full();
                Ok(())
            }),
            None => {
                let reason = "this user may not mount a file system";
                Trial::test(format!("{name} ({reason})"), move || Err(reason.into())).with_ignored_flag(true)
            }
        }
    }

    fn bake(output: &Path) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_catoptric"));
        command.arg("bake").args(WHAT).arg("-o").arg(output).output().unwrap()
    }

    /// First there is room for some units, then for all of them but not for the merged file beside them.
    fn is_full() {
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
}
