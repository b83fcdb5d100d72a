// The form makes a case, a worker runs it, and the page shows its report.
'use strict';
(() => {
  const { presets, case: first, reference } = JSON.parse(document.getElementById('data').textContent);
  const form = document.getElementById('form');
  const status = document.getElementById('status');
  const result = document.getElementById('result');
  const fields = form.elements;

  const options = (select, all, words) => {
    for (const name of Object.keys(all)) { select.add(new Option(`${name}: ${words(all[name])}`, name)); }
  };
  options(fields.fabric, presets.fabrics, words => words);
  options(fields.projectile, presets.projectiles, preset => preset.what);

  /** The case that the form asks for. What is as in the first case stays as it is there. */
  function asked() {
    const made = structuredClone(first);
    const [fabric, plies, velocity] = [fields.fabric.value, Number(fields.plies.value), Number(fields.velocity.value)];
    const preset = presets.projectiles[fields.projectile.value];
    made.fabric.file = `fabrics/${fabric}.json`;
    made.pack.plies = plies;
    if (fields.projectile.value !== 'rcc-paper') {
      made.projectile = { ...preset.projectile, velocity_m_s: velocity, friction: first.projectile.friction };
      for (const [place, source] of Object.entries(preset.sources)) { made.sources[`/projectile${place}`] = source; }
    }
    made.projectile.velocity_m_s = velocity;
    if (JSON.stringify(made) !== JSON.stringify(first)) {
      made.title = `${fabric}, ${plies === 1 ? '1 ply' : `${plies} plies`}, ${preset.title} at ${velocity} m/s`;
    }
    return made;
  }

  const write = made => { fields.text.value = JSON.stringify(made, null, 2); };

  /** Says something; `bad`: as an error, with its line breaks. */
  function say(words, bad) {
    const line = document.createElement(bad ? 'pre' : 'p');
    line.textContent = words;
    status.replaceChildren(line);
  }

  /** Largest difference of the velocity from the one in double precision [m/s]. Both have rows at the same times, as far as both go. */
  function difference({ velocity }) {
    const rows = Math.min(velocity.length, reference.length);
    return Math.max(...velocity.slice(0, rows).map((v, row) => Math.abs(v - reference[row])));
  }

  /** Bytes of the library, unpacked once. */
  let unpacked = null;
  function library() {
    unpacked ??= (async () => {
      const packed = Uint8Array.from(atob(document.getElementById('library').textContent), letter => letter.charCodeAt(0));
      return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'))).arrayBuffer();
    })();
    return unpacked;
  }

  /** Whether a shot is computed by WebGPU: `auto` takes no software that acts as a graphics processor. */
  async function takesGpu(by) {
    if (by !== 'auto') { return by === 'gpu'; }
    const adapter = await navigator.gpu?.requestAdapter();
    return Boolean(adapter) && !(adapter.info.isFallbackAdapter ?? adapter.isFallbackAdapter);
  }

  let worker = null;

  /** Runs a case in a worker; another shot ends one that is under way. */
  async function shoot(text, gpu) {
    const bytes = await library();
    worker?.terminate();
    const source = JSON.parse(document.getElementById('worker').textContent);
    const place = URL.createObjectURL(new Blob([source], { type: 'text/javascript' }));
    const own = worker = new Worker(place);
    const bar = document.createElement('progress');
    const line = document.createElement('p');
    line.textContent = gpu ? 'WebGPU compiles the kernels…' : 'The processor begins…';
    status.replaceChildren(line, bar);
    return new Promise((resolve, reject) => {
      own.onerror = event => reject(new Error(event.message));
      own.onmessage = ({ data: { progress, shot, error } }) => {
        if (progress) {
          [bar.max, bar.value] = [progress.end, progress.time];
          line.textContent = `${progress.time.toFixed(1)} of at most ${progress.end.toFixed(0)} µs, ${progress.velocity.toFixed(1)} m/s`;
        } else if (shot) {
          resolve(shot);
        } else {
          reject(new Error(error));
        }
      };
      own.postMessage({ library: bytes, text, gpu });
    }).finally(() => {
      own.terminate();
      URL.revokeObjectURL(place);
    });
  }

  /** Shows the report, as high as it is. */
  function show(shot) {
    const frame = document.createElement('iframe');
    frame.title = 'Report of the shot';
    frame.srcdoc = shot.report;
    frame.onload = () => {
      const grow = () => { frame.style.height = `${frame.contentDocument.documentElement.scrollHeight}px`; };
      grow();
      new ResizeObserver(grow).observe(frame.contentDocument.body);
    };
    const save = document.createElement('a');
    save.textContent = 'Save this report';
    save.download = 'report.html';
    save.href = URL.createObjectURL(new Blob([shot.report], { type: 'text/html' }));
    status.append(save);
    result.replaceChildren(frame);
  }

  /** Runs a case where the form says. Where WebGPU was not asked for by name and fails, the processor takes over. */
  async function compute(text) {
    const by = fields.by.value;
    let note = '';
    if (await takesGpu(by)) {
      try {
        const shot = await shoot(text, true);
        if (!shot.summary.device_lost) { return { shot, note }; }
        throw new Error(`WebGPU gave up: ${shot.summary.device_lost}`);
      } catch (error) {
        if (by !== 'auto') { throw error; }
        note = ` ${error.message}.`;
      }
    }
    return { shot: await shoot(text, false), note };
  }

  async function run() {
    const text = fields.text.value;
    try {
      const start = performance.now();
      const { shot, note } = await compute(text);
      const { outcome, backend } = shot.summary;
      const by = backend === 'gpu' ? 'WebGPU' : 'the processor';
      let words = `Computed by ${by} in single precision: ${((performance.now() - start) / 1000).toFixed(1)} s.${note}`;
      if (text === JSON.stringify(first, null, 2)) {
        const most = difference(shot);
        const part = most / first.projectile.velocity_m_s;
        words += ` The velocity is off that in double precision by ${most.toExponential(1)} m/s at most, ${part.toExponential(1)} of that at impact.`;
      }
      say(words, false);
      show(shot);
      console.log(`ripstop: ${JSON.stringify({ outcome, backend, time: [...shot.time], velocity: [...shot.velocity], words })}`);
    } catch (error) {
      result.replaceChildren();
      say(error.message, true);
      console.log(`ripstop: ${JSON.stringify({ error: error.message })}`);
    }
  }

  form.addEventListener('submit', event => {
    event.preventDefault();
    run();
  });
  for (const name of ['fabric', 'plies', 'projectile', 'velocity']) {
    fields[name].addEventListener('change', () => { if (form.checkValidity()) { write(asked()); } });
  }
  document.getElementById('link').addEventListener('click', event => {
    event.preventDefault();
    location.hash = new URLSearchParams({ case: fields.text.value, by: fields.by.value });
  });

  write(asked());
  // A link may bring a case, and ask for it to be run.
  const given = new URLSearchParams(location.hash.slice(1));
  if (given.has('case')) { fields.text.value = given.get('case'); }
  if (given.has('by')) { fields.by.value = given.get('by'); }
  if (given.has('run')) { run(); }
})();
