#include "common/rpc/certificate.h"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "common/base/hash.h"
#include "common/base/names.h"
#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "common/rpc/free_with.h"

namespace parallax {
namespace {

constexpr double kSecondsOfDay = 86400;
constexpr double kClockSkew_s = 300;
constexpr double kWarnBeforeExpiry_s = 30 * kSecondsOfDay;
constexpr std::string_view kRoleUri = "urn:parallax:role:";
constexpr size_t kMaxPem = 1 << 20;

using Certificate = std::unique_ptr<X509, FreeWith<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, FreeWith<EVP_PKEY_free>>;
using Bio = std::unique_ptr<BIO, FreeWith<BIO_free_all>>;
using Extension = std::unique_ptr<X509_EXTENSION, FreeWith<X509_EXTENSION_free>>;
using Names = std::unique_ptr<GENERAL_NAMES, FreeWith<GENERAL_NAMES_free>>;

absl::Status OpenSslError(const std::string& what) {
  char text[256] = "no reason given";
  if (const unsigned long code = ERR_get_error(); code != 0) {
    ERR_error_string_n(code, text, sizeof text);
  }
  ERR_clear_error();
  return Internal("{}: {}", what, text);
}

// Source: RFC 5280, appendix A.1: ub-common-name.
constexpr size_t kMaxCommonName = 64;

absl::Status CheckCertificateName(const std::string& name) {
  RETURN_IF_ERROR(CheckName("certificate name", name));
  if (name.size() <= kMaxCommonName) return absl::OkStatus();
  return InvalidArgument("certificate name {} is too long, allowed are at most {} characters",
                         Quoted(name), kMaxCommonName);
}

bool IsIpAddress(const std::string& host) {
  unsigned char bytes[16];
  return inet_pton(AF_INET, host.c_str(), bytes) == 1 ||
         inet_pton(AF_INET6, host.c_str(), bytes) == 1;
}

// "DNS:farm,IP:10.0.0.1". Every character is checked, so none can add an entry of its own.
absl::StatusOr<std::string> AlternativeNames(const std::vector<std::string>& hosts) {
  std::string text;
  for (const std::string& host : hosts) {
    const auto in_name = [](unsigned char c) { return std::isalnum(c) || c == '.' || c == '-'; };
    const bool address = IsIpAddress(host);
    if (!address && (host.empty() || host.size() > 253 || host[0] == '.' || host[0] == '-' ||
                     !std::all_of(host.begin(), host.end(), in_name))) {
      const auto bad = std::find_if_not(host.begin(), host.end(), in_name);
      return InvalidArgument(
          "host {}: wanted a host name or an IP address{}", Quoted(host),
          bad == host.end() ? ""
                            : fmt::format("; a name has letters, digits, '-' and '.', and no {}",
                                          Quoted(std::string_view(&*bad, 1))));
    }
    text += (text.empty() ? "" : ",") + std::string(address ? "IP:" : "DNS:") + host;
  }
  if (text.empty()) return InvalidArgument("a server's certificate needs a host");
  return text;
}

absl::StatusOr<std::string> TextOf(BIO* bio) {
  const char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  if (size <= 0) return OpenSslError("PEM");
  return std::string(data, static_cast<size_t>(size));
}

absl::StatusOr<KeyPair> ToPem(X509* certificate, EVP_PKEY* key) {
  const Bio crt(BIO_new(BIO_s_mem()));
  const Bio pem(BIO_new(BIO_s_mem()));
  if (PEM_write_bio_X509(crt.get(), certificate) != 1 ||
      PEM_write_bio_PrivateKey(pem.get(), key, nullptr, nullptr, 0, nullptr, nullptr) != 1) {
    return OpenSslError("PEM");
  }
  KeyPair pair;
  ASSIGN_OR_RETURN(pair.certificate_pem, TextOf(crt.get()));
  ASSIGN_OR_RETURN(pair.key_pem, TextOf(pem.get()));
  return pair;
}

absl::StatusOr<Certificate> ParseCertificate(const std::string& pem) {
  const Bio bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  Certificate certificate(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr));
  ERR_clear_error();
  if (certificate == nullptr) return InvalidArgument("not a certificate in PEM");
  return certificate;
}

absl::StatusOr<Key> ParseKey(const std::string& pem) {
  const Bio bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  // Keeps OpenSSL from asking the terminal for the password of an encrypted key.
  const auto no_password = [](char*, int, int, void*) { return 0; };
  Key key(PEM_read_bio_PrivateKey(bio.get(), nullptr, no_password, nullptr));
  ERR_clear_error();
  if (key == nullptr) return InvalidArgument("not an unencrypted private key in PEM");
  return key;
}

// A certificate of `subject` for a fresh key, with these extensions, signed by `issuer` (null: by
// itself).
struct Parent {
  X509* certificate = nullptr;
  EVP_PKEY* key = nullptr;
};

absl::Status AddExtension(X509* certificate, X509* issuer, int nid, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509V3_set_ctx_nodb(&context);
  const Extension extension(X509V3_EXT_conf_nid(nullptr, &context, nid, value.c_str()));
  if (extension == nullptr || X509_add_ext(certificate, extension.get(), -1) != 1) {
    return OpenSslError(std::string("extension ") + OBJ_nid2sn(nid));
  }
  return absl::OkStatus();
}

absl::Status SetSerial(X509* certificate) {
  unsigned char bytes[16];
  if (RAND_bytes(bytes, sizeof bytes) != 1) return OpenSslError("random number");
  bytes[0] &= 0x7f;  // Positive.
  BIGNUM* number = BN_bin2bn(bytes, sizeof bytes, nullptr);
  const bool set = number != nullptr &&
                   BN_to_ASN1_INTEGER(number, X509_get_serialNumber(certificate)) != nullptr;
  BN_free(number);
  return set ? absl::OkStatus() : OpenSslError("serial number");
}

double UnixSecondsOf(const ASN1_TIME* time) {
  tm parts{};
  if (ASN1_TIME_to_tm(time, &parts) != 1) return 0;
  return static_cast<double>(timegm(&parts));
}

absl::StatusOr<KeyPair> Make(const CertificateOrder& order, const std::string& unit, Parent parent,
                             const std::vector<std::pair<int, std::string>>& extensions) {
  RETURN_IF_ERROR(CheckCertificateName(order.name));
  if (!(order.days > 0 && order.days <= 36500)) {
    return InvalidArgument("a certificate's days must be in (0, 36500]");
  }
  const Key key(EVP_EC_gen("P-256"));
  const Certificate certificate(X509_new());
  if (key == nullptr || certificate == nullptr) return OpenSslError("key");
  X509* const x509 = certificate.get();
  X509_set_version(x509, X509_VERSION_3);
  RETURN_IF_ERROR(SetSerial(x509));
  double end_s = order.now_unix_s + order.days * kSecondsOfDay;
  if (parent.certificate != nullptr) {
    end_s = std::min(end_s, UnixSecondsOf(X509_get0_notAfter(parent.certificate)));
  }
  ASN1_TIME_set(X509_getm_notBefore(x509), static_cast<time_t>(order.now_unix_s - kClockSkew_s));
  ASN1_TIME_set(X509_getm_notAfter(x509), static_cast<time_t>(end_s));
  X509_NAME* const subject = X509_get_subject_name(x509);
  const auto add = [subject](const char* field, const std::string& value) {
    return X509_NAME_add_entry_by_txt(subject, field, MBSTRING_UTF8,
                                      reinterpret_cast<const unsigned char*>(value.c_str()), -1, -1,
                                      0) == 1;
  };
  if (!add("O", "Parallax") || !add("OU", unit) || !add("CN", order.name)) {
    return OpenSslError("subject");
  }
  if (X509_set_pubkey(x509, key.get()) != 1) return OpenSslError("public key");
  X509* const issuer = parent.certificate != nullptr ? parent.certificate : x509;
  if (X509_set_issuer_name(x509, X509_get_subject_name(issuer)) != 1) return OpenSslError("issuer");
  for (const auto& [nid, value] : extensions) {
    RETURN_IF_ERROR(AddExtension(x509, issuer, nid, value));
  }
  if (X509_sign(x509, parent.key != nullptr ? parent.key : key.get(), EVP_sha256()) == 0) {
    return OpenSslError("signature");
  }
  return ToPem(x509, key.get());
}

absl::StatusOr<KeyPair> Issue(const KeyPair& authority, const CertificateOrder& order,
                              const std::string& unit, const char* usage,
                              const std::string& alternative_names) {
  ASSIGN_OR_RETURN(const Certificate issuer, ParseCertificate(authority.certificate_pem));
  ASSIGN_OR_RETURN(const Key key, ParseKey(authority.key_pem));
  if (UnixSecondsOf(X509_get0_notAfter(issuer.get())) <= order.now_unix_s) {
    return FailedPrecondition("the authority's own certificate has expired");
  }
  return Make(order, unit, {issuer.get(), key.get()},
              {{NID_basic_constraints, "critical,CA:FALSE"},
               {NID_key_usage, "critical,digitalSignature"},
               {NID_ext_key_usage, usage},
               {NID_subject_alt_name, alternative_names},
               {NID_subject_key_identifier, "hash"},
               {NID_authority_key_identifier, "keyid:always"}});
}

std::string TextOf(const ASN1_STRING* text) {
  return {reinterpret_cast<const char*>(ASN1_STRING_get0_data(text)),
          static_cast<size_t>(ASN1_STRING_length(text))};
}

std::string AddressOf(const ASN1_OCTET_STRING* bytes) {
  char text[INET6_ADDRSTRLEN] = "";
  const int size = ASN1_STRING_length(bytes);
  if (size == 4 || size == 16) {
    inet_ntop(size == 4 ? AF_INET : AF_INET6, ASN1_STRING_get0_data(bytes), text, sizeof text);
  }
  return text;
}

absl::StatusOr<std::string> ReadPem(const std::string& dir, const char* name) {
  absl::StatusOr<std::string> text = ReadFile(dir + "/" + name, kMaxPem);
  if (text.ok()) return text;
  return MakeError(text.status().code(),
                   std::string(ToStd(text.status().message())) +
                       "; a TLS folder has ca.crt, tls.crt and tls.key, as `coordinator init DIR "
                       "--issue ROLE NAME` makes them");
}

std::string FingerprintOf(X509* certificate) {
  unsigned char* der = nullptr;
  const int size = i2d_X509(certificate, &der);
  if (size < 0) return "";
  const std::string bytes(reinterpret_cast<const char*>(der), static_cast<size_t>(size));
  OPENSSL_free(der);
  return Sha256Hex(bytes);
}

}  // namespace

std::string DateAndTimeOf(double unix_s) {
  const time_t seconds = static_cast<time_t>(unix_s);
  tm parts{};
  gmtime_r(&seconds, &parts);
  char text[32];
  strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &parts);
  return text;
}

std::string DateOf(double unix_s) { return DateAndTimeOf(unix_s).substr(0, 10); }

absl::StatusOr<KeyPair> MakeAuthority(const CertificateOrder& order) {
  return Make(order, "authority", {},
              {{NID_basic_constraints, "critical,CA:TRUE,pathlen:0"},
               {NID_key_usage, "critical,keyCertSign,cRLSign"},
               {NID_subject_key_identifier, "hash"}});
}

absl::StatusOr<KeyPair> IssueServer(const KeyPair& authority, const CertificateOrder& order,
                                    const std::vector<std::string>& hosts) {
  ASSIGN_OR_RETURN(const std::string names, AlternativeNames(hosts));
  return Issue(authority, order, "coordinator", "serverAuth", names);
}

absl::StatusOr<KeyPair> IssueClient(const KeyPair& authority, const CertificateOrder& order,
                                    Role role) {
  const std::string name(RoleName(role));
  return Issue(authority, order, name, "clientAuth", "URI:" + std::string(kRoleUri) + name);
}

absl::StatusOr<CertificateFacts> ReadCertificate(const std::string& pem) {
  ASSIGN_OR_RETURN(const Certificate certificate, ParseCertificate(pem));
  CertificateFacts facts;
  X509_NAME* const subject = X509_get_subject_name(certificate.get());
  if (const int at = X509_NAME_get_index_by_NID(subject, NID_commonName, -1); at >= 0) {
    facts.name = TextOf(X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, at)));
  }
  const Names names(static_cast<GENERAL_NAMES*>(
      X509_get_ext_d2i(certificate.get(), NID_subject_alt_name, nullptr, nullptr)));
  for (int i = 0; names != nullptr && i < sk_GENERAL_NAME_num(names.get()); ++i) {
    const GENERAL_NAME* name = sk_GENERAL_NAME_value(names.get(), i);
    if (name->type == GEN_DNS) {
      facts.hosts.push_back(TextOf(name->d.dNSName));
    } else if (name->type == GEN_IPADD) {
      facts.hosts.push_back(AddressOf(name->d.iPAddress));
    } else if (name->type == GEN_URI) {
      const std::string uri = TextOf(name->d.uniformResourceIdentifier);
      if (uri.rfind(kRoleUri, 0) == 0) facts.role = ParseRole(uri.substr(kRoleUri.size()));
    }
  }
  facts.not_before_unix_s = UnixSecondsOf(X509_get0_notBefore(certificate.get()));
  facts.not_after_unix_s = UnixSecondsOf(X509_get0_notAfter(certificate.get()));
  facts.sha256 = FingerprintOf(certificate.get());
  return facts;
}

absl::StatusOr<std::shared_ptr<const TlsIdentity>> LoadTlsIdentity(const std::string& dir,
                                                                   Clock& clock) {
  auto identity = std::make_shared<TlsIdentity>();
  identity->dir = dir;
  ASSIGN_OR_RETURN(identity->ca_pem, ReadPem(dir, "ca.crt"));
  ASSIGN_OR_RETURN(identity->own.certificate_pem, ReadPem(dir, "tls.crt"));
  ASSIGN_OR_RETURN(identity->own.key_pem, ReadPem(dir, "tls.key"));
  const auto ca = ParseCertificate(identity->ca_pem);
  if (!ca.ok()) return WithContext(ca.status(), dir + "/ca.crt");
  const auto own = ParseCertificate(identity->own.certificate_pem);
  if (!own.ok()) return WithContext(own.status(), dir + "/tls.crt");
  const auto key = ParseKey(identity->own.key_pem);
  if (!key.ok()) return WithContext(key.status(), dir + "/tls.key");
  const auto facts = ReadCertificate(identity->own.certificate_pem);
  if (!facts.ok()) return WithContext(facts.status(), dir + "/tls.crt");
  identity->facts = *facts;

  const bool fits = X509_check_private_key(own->get(), key->get()) == 1;
  const bool is_signed = X509_verify(own->get(), X509_get0_pubkey(ca->get())) == 1;
  ERR_clear_error();
  if (!fits) return FailedPrecondition("{}: tls.key is not the key of tls.crt", dir);
  if (!is_signed) {
    return FailedPrecondition(
        "{}: tls.crt was not signed by the authority in ca.crt; both must come from the same "
        "`coordinator init DIR`",
        dir);
  }
  const double now_s = clock.UnixSeconds();
  if (facts->not_after_unix_s <= now_s) {
    return FailedPrecondition(
        "{}/tls.crt expired on {}; issue a new one with `coordinator init` (see coordinator init "
        "--help)",
        dir, DateOf(facts->not_after_unix_s));
  }
  if (facts->not_before_unix_s > now_s) {
    return FailedPrecondition("{}/tls.crt is not valid before {}; is this machine's clock right?",
                              dir, DateOf(facts->not_before_unix_s));
  }
  if (facts->not_after_unix_s - now_s < kWarnBeforeExpiry_s) {
    LogWarning("certificate expires soon",
               {{"file", dir + "/tls.crt"}, {"on", DateOf(facts->not_after_unix_s)}});
  }
  struct stat info {};
  if (stat((dir + "/tls.key").c_str(), &info) == 0 && (info.st_mode & S_IRWXO) != 0) {
    LogWarning("private key is open to all users of this machine; chmod 600 it",
               {{"file", dir + "/tls.key"}});
  }
  return std::shared_ptr<const TlsIdentity>(std::move(identity));
}

}  // namespace parallax
