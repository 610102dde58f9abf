//! Text in chunks of whole lines, read on one thread, parsed on several, handed out in order.

use std::io::Read;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread;

use super::grouped;
use super::rows::{Chunk, RowError, RowPlan};
use crate::live::read_some;
use crate::{Block, Error};

/// Bytes of a chunk: a few L2 caches' worth is parsed between two hand-overs.
const CHUNK: usize = 512 * 1024;
/// Bytes that a log which is still being written is asked for at once.
const LIVE: usize = 128 * 1024;
/// No line of a table is longer.
const LONGEST_LINE: usize = 4 << 20;

/// Cuts a stream into chunks that end with a line.
struct Cutter {
    reader: Box<dyn Read + Send>,
    rest: Vec<u8>,
    /// What ended the stream early; told after the whole lines before it.
    error: Option<Error>,
    done: bool,
    /// Whole lines are handed on as they come.
    is_live: bool,
}

impl Cutter {
    fn next(&mut self, mut buffer: Vec<u8>) -> Result<Option<Vec<u8>>, Error> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        if self.done {
            return Ok(None);
        }
        buffer.clear();
        buffer.append(&mut self.rest);
        loop {
            let want = (CHUNK.saturating_sub(buffer.len())).max(CHUNK / 8);
            let old = buffer.len();
            let read = if self.is_live {
                read_some(&mut *self.reader, &mut buffer, old + want.min(LIVE))
            } else {
                let mut part = self.reader.by_ref().take(want as u64);
                part.read_to_end(&mut buffer)
            };
            let got = match read {
                Ok(got) => got,
                Err(error) => {
                    self.done = true;
                    let Some(end) = memchr::memrchr(b'\n', &buffer) else {
                        return Err(Error::read(error));
                    };
                    self.error = Some(Error::read(error));
                    buffer.truncate(end + 1);
                    return Ok(Some(buffer));
                }
            };
            if got == 0 || (got < want && !self.is_live) {
                self.done = true;
                return Ok(Some(buffer).filter(|b| !b.is_empty()));
            }
            if let Some(end) = memchr::memrchr(b'\n', &buffer[old..]) {
                self.rest.extend_from_slice(&buffer[old + end + 1..]);
                buffer.truncate(old + end + 1);
                return Ok(Some(buffer));
            }
            if buffer.len() > LONGEST_LINE {
                return Err(Error::data("a line is longer than 4 MiB: this is no table")
                    .advise("save the log as CSV with a row a line, or as .npy"));
            }
        }
    }
}

enum Failure {
    Row(RowError),
    Read(Error),
}

type Answer = Result<Chunk, Failure>;

/// The chunks of a table, parsed, in order.
pub(crate) struct Chunks {
    plan: Arc<RowPlan>,
    mode: Mode,
    /// Rows and lines handed out so far.
    rows: u64,
    lines: u64,
    /// Cells of text taken for missing values, a count a column of values.
    missing: Vec<u64>,
    failed: bool,
}

enum Mode {
    /// Read and parsed where it is asked for.
    Inline { cutter: Cutter, buffer: Vec<u8> },
    /// Answers come in the order of the chunks.
    Threads {
        answers: Receiver<Receiver<Answer>>,
        /// Blocks handed back: fresh pages cost a fifth of the time.
        spare: SyncSender<Block>,
    },
}

impl Chunks {
    pub(crate) fn new(
        reader: Box<dyn Read + Send>,
        plan: RowPlan,
        lines_before: u64,
        threads: usize,
        is_live: bool,
    ) -> Self {
        let plan = Arc::new(plan);
        let cutter = Cutter {
            reader,
            rest: Vec::new(),
            error: None,
            done: false,
            is_live,
        };
        let workers = match threads {
            0 => thread::available_parallelism().map_or(1, usize::from),
            n => n,
        };
        let mode = if workers <= 1 {
            Mode::Inline {
                cutter,
                buffer: Vec::new(),
            }
        } else {
            let workers = workers.min(16);
            let (spare, blocks) = sync_channel(workers + 2);
            Mode::Threads {
                answers: start(cutter, &plan, workers, blocks),
                spare,
            }
        };
        Self {
            plan,
            mode,
            rows: 0,
            lines: lines_before,
            missing: Vec::new(),
            failed: false,
        }
    }

    /// The next chunk's rows; `false` at the end.
    pub(crate) fn next(&mut self, block: &mut Block) -> Result<bool, Error> {
        if self.failed {
            return Ok(false);
        }
        let answer = match &mut self.mode {
            Mode::Inline { cutter, buffer } => match cutter.next(std::mem::take(buffer)) {
                Ok(None) => None,
                Ok(Some(text)) => {
                    let answer = self
                        .plan
                        .read(&text, std::mem::take(block))
                        .map_err(Failure::Row);
                    *buffer = text;
                    Some(answer)
                }
                Err(e) => Some(Err(Failure::Read(e))),
            },
            Mode::Threads { answers, .. } => answers.recv().ok().and_then(|one| one.recv().ok()),
        };
        match answer {
            None => Ok(false),
            Some(Ok(chunk)) => {
                self.rows += chunk.block.rows as u64;
                self.lines += chunk.lines;
                self.missing.resize(chunk.missing.len(), 0);
                for (all, some) in self.missing.iter_mut().zip(&chunk.missing) {
                    *all += some;
                }
                let old = std::mem::replace(block, chunk.block);
                if let Mode::Threads { spare, .. } = &self.mode {
                    // Where nobody has room for it, it is dropped.
                    let _ = spare.try_send(old);
                }
                Ok(true)
            }
            Some(Err(failure)) => {
                self.failed = true;
                Err(match failure {
                    Failure::Read(e) if self.rows > 0 && e.place().is_none() => {
                        e.at(format!("after {} whole rows", grouped(self.rows)))
                    }
                    Failure::Read(e) => e,
                    Failure::Row(e) => self.describe(&e),
                })
            }
        }
    }

    /// Cells of text that were taken for missing values, a count a column of values.
    pub(crate) fn missing(&self) -> &[u64] {
        &self.missing
    }

    fn describe(&self, error: &RowError) -> Error {
        super::row_error(error, &self.plan, self.rows, self.lines)
    }
}

fn start(
    mut cutter: Cutter,
    plan: &Arc<RowPlan>,
    workers: usize,
    blocks: Receiver<Block>,
) -> Receiver<Receiver<Answer>> {
    // The bound on answers is the bound on memory.
    let (answers_in, answers) = sync_channel::<Receiver<Answer>>(workers + 1);
    let (work_in, work) = sync_channel::<(Vec<u8>, SyncSender<Answer>)>(1);
    let (spare_in, spare) = sync_channel::<Vec<u8>>(workers + 2);
    let work = Arc::new(Mutex::new(work));
    let blocks = Arc::new(Mutex::new(blocks));
    for _ in 0..workers {
        let (work, plan, spare_in) = (Arc::clone(&work), Arc::clone(plan), spare_in.clone());
        let blocks = Arc::clone(&blocks);
        thread::spawn(move || {
            loop {
                let job = match work.lock() {
                    Ok(queue) => queue.recv(),
                    Err(_) => return,
                };
                let Ok((text, answer)) = job else { return };
                let block = blocks
                    .lock()
                    .ok()
                    .and_then(|spare| spare.try_recv().ok())
                    .unwrap_or_default();
                let chunk = plan.read(&text, block).map_err(Failure::Row);
                // The consumer may be gone; then nobody wants the answer.
                let _ = answer.send(chunk);
                let _ = spare_in.try_send(text);
            }
        });
    }
    thread::spawn(move || {
        loop {
            let buffer = spare.try_recv().unwrap_or_default();
            let text = cutter.next(buffer);
            let (answer_in, answer) = sync_channel(1);
            let is_last = !matches!(text, Ok(Some(_)));
            match text {
                Ok(Some(text)) => {
                    if answers_in.send(answer).is_err() || work_in.send((text, answer_in)).is_err()
                    {
                        return;
                    }
                }
                Ok(None) => {}
                Err(e) => {
                    let _ = answer_in.send(Err(Failure::Read(e)));
                    let _ = answers_in.send(answer);
                }
            }
            if is_last {
                return;
            }
        }
    });
    answers
}
