/** The server, asked under the address of this page: the token is part of it. */

import type {
  Albedo,
  ComparisonTable,
  Entry,
  FitRequest,
  Home,
  Job,
  LightSet,
  Problem,
  SampleColumns,
  SampleDetail,
  SlicePanel,
  TrustPlane,
  Upload,
} from "../messages";

/** What the server refused, in its own words. */
export class Refused extends Error {
  constructor(
    readonly kind: string,
    message: string,
  ) {
    super(message);
  }
}

async function ask(path: string, init: RequestInit = {}): Promise<Response> {
  let answer: Response;
  try {
    answer = await fetch(path, init);
  } catch {
    throw new Refused("Unreachable", "the server does not answer: was brdfit view ended?");
  }
  if (answer.ok) return answer;
  const text = await answer.text();
  let problem: Problem = { kind: String(answer.status), message: text };
  try {
    problem = JSON.parse(text) as Problem;
  } catch {
    // not one of ours: the text itself says what it is
  }
  throw new Refused(problem.kind, problem.message);
}

async function json<T>(path: string, init: RequestInit = {}): Promise<T> {
  return (await (await ask(path, init)).json()) as T;
}

function query(parameters: Record<string, string | number>): string {
  const pairs = Object.entries(parameters).map(([name, value]) => [name, String(value)]);
  return new URLSearchParams(pairs).toString();
}

const entry = (id: string) => `api/entries/${id}`;

const fetchTable = async (id: string) =>
  new Uint8Array(await (await ask(`${entry(id)}/table`)).arrayBuffer());

/** Tables that were asked for before anybody could draw them. */
const coming = new Map<string, Promise<Uint8Array>>();

export const api = {
  home: () => json<Home>("api/home"),
  entry: (id: string) => json<Entry>(entry(id)),
  table: (id: string) => {
    const found = coming.get(id) ?? fetchTable(id);
    coming.delete(id);
    return found;
  },
  /** Ask for a table now: it comes while the page is still being made. */
  tableAhead(id: string): void {
    const promise = fetchTable(id);
    promise.catch(() => {}); // whoever takes it is told
    coming.set(id, promise);
  },
  albedo: (id: string) => json<Albedo>(`${entry(id)}/albedo`),
  samples: (id: string) => json<SampleColumns>(`${entry(id)}/samples`),
  sample: (id: string, n: number) => json<SampleDetail>(`${entry(id)}/samples/${n}`),
  slice: (id: string, theta_i: number, phi: number) =>
    json<SlicePanel>(`${entry(id)}/slice?${query({ theta_i, phi })}`),
  trust: (id: string, phi_d: number) => json<TrustPlane>(`${entry(id)}/trust?${query({ phi_d })}`),
  comparison: (reference: string, test: string) =>
    json<ComparisonTable>(`api/comparison?${query({ reference, test })}`),
  upload: (file: File, options: Record<string, string>) =>
    json<Upload>(`api/uploads?${query({ name: file.name, ...options })}`, {
      method: "POST",
      body: file,
    }),
  environment: (file: File) =>
    json<LightSet>(`api/environments?${query({ name: file.name })}`, {
      method: "POST",
      body: file,
    }),
  fit: (request: FitRequest) =>
    json<Job>("api/fits", { method: "POST", body: JSON.stringify(request) }),
  cancel: (id: string) => json<Job>(`api/jobs/${id}`, { method: "DELETE" }),
  downloadAddress: (id: string, kind: string, format: string) =>
    `${entry(id)}/download?${query({ kind, format })}`,

  /** Tell `heard` of every change of a job; return a function that stops listening. */
  watch(id: string, heard: (job: Job) => void): () => void {
    const source = new EventSource(`api/jobs/${id}/events`);
    source.onmessage = (event: MessageEvent<string>) => {
      const job = JSON.parse(event.data) as Job;
      if (job.state !== "waiting" && job.state !== "running") source.close();
      heard(job);
    };
    return () => source.close();
  },
};
