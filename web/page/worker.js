// Runs a case beside the page, which stays quick meanwhile. The page starts another worker for the next one.

function showProgress(time, end, velocity) { postMessage({ progress: { time, end, velocity } }); }

function showPanic(text) { postMessage({ error: `the program ended where it should not: ${text}` }); }

onmessage = async ({ data: { library, text, gpu } }) => {
  try {
    await wasm_bindgen({ module_or_path: library });
    const shot = await wasm_bindgen.run(text, gpu);
    const { report, summary, time, velocity } = shot;
    postMessage({ shot: { report, summary: JSON.parse(summary), time, velocity } });
  } catch (error) {
    postMessage({ error: String(error.message ?? error) });
  }
};
