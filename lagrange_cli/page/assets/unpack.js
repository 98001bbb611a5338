// The page begins here: what it shows, its equations and its scripts are packed as text (`page/packed.py`).

async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function unpackedText(text) { return new TextDecoder().decode(await unpacked(text)); }

async function addScript(text) {
  const script = document.createElement("script");
  script.textContent = await unpackedText(text);
  document.head.append(script);
}

async function begin() {
  const data = JSON.parse(document.getElementById("data").textContent);
  for (const name of ["coordinates", "velocities", "drawing", "engine"]) data[name] = JSON.parse(await unpackedText(data[name]));
  await addScript(data.script);
  await main(data);
}

begin().catch((error) => {
  document.getElementById("notice").hidden = false;
  document.getElementById("notice").textContent = `This browser cannot run the page: ${error.message}`;
  console.error(error);
});
