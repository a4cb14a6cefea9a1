//! Memory that the system refuses, as under `ulimit -v` or the `h_vmem` of a batch system: the command ends with a message instead of an abort.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Allocator of the system, which never returns without memory.
struct Memory;

#[global_allocator]
static MEMORY: Memory = Memory;

/// Largest size of values that are allocated while a lock is held, which cleaning up needs; bytes.
const LARGEST_LOCKED_BYTES: usize = 1 << 20;

/// Whether the command is about to end.
static IS_ENDING: AtomicBool = AtomicBool::new(false);

/// Ends the command with a message. Allocates nothing before the message is written.
#[cold]
fn refused(bytes: usize) -> ! {
    if IS_ENDING.swap(true, Ordering::Relaxed) {
        // Another thread, or cleaning up, needs memory too.
        std::thread::sleep(Duration::from_millis(100));
        signal_hook::low_level::exit(2);
    }
    // Standard error may be closed.
    let _ = writeln!(
        std::io::stderr(),
        "error: the system refuses {} MiB of memory\n  \
         hint: ask for fewer particles, states or frames, or raise the limit (ulimit -v, h_vmem)",
        bytes.div_ceil(1 << 20)
    );
    if bytes > LARGEST_LOCKED_BYTES {
        onset_umat::end_all();
        onset_study::output::end_all();
    }
    signal_hook::low_level::exit(2)
}

fn given(pointer: *mut u8, bytes: usize) -> *mut u8 {
    if pointer.is_null() {
        refused(bytes);
    }
    pointer
}

// SAFETY: each call is passed on to the allocator of the system. A null pointer ends the process.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Memory {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: `System` has the same conditions as this function.
        given(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: `System` has the same conditions as this function.
        given(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: `System` allocated the memory, and has the same conditions as this function.
        given(unsafe { System.realloc(pointer, layout, size) }, size)
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `System` allocated the memory, and has the same conditions as this function.
        unsafe { System.dealloc(pointer, layout) }
    }
}
