// The page of one cam, or of a few side by side.

function showCamsPage(data) {
  const find = (id) => document.getElementById(id);
  const player = new Player(find("player"));
  showCams(player, find("stage"), find("diagrams"), data.cams, data.labels, data.words);
  player.go(0);
  return { player };
}

const START = showCamsPage;
