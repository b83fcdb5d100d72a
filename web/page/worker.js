// Runs one case after another, beside the page, which stays quick meanwhile.

function showProgress(time, end, velocity) { postMessage({ progress: { time, end, velocity } }); }

function showPanic(text) { postMessage({ error: `the program ended where it should not: ${text}` }); }

let started = null;

onmessage = async ({ data: { library, text, gpu } }) => {
  try {
    started ??= wasm_bindgen({ module_or_path: library });
    await started;
    const shot = await wasm_bindgen.run(text, gpu);
    const { report, summary, time, velocity, force } = shot;
    shot.free();
    postMessage({ shot: { report, summary: JSON.parse(summary), time, velocity, force } });
  } catch (error) {
    postMessage({ error: String(error.message ?? error) });
  }
};
